#include "tools/job_file.h"

#include "engine/errors.h"

#include <toml++/toml.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

namespace slicemorph {
namespace {

const char* describe(JobType type) {
  switch (type) {
    case JobType::kInteger:
      return "a whole number";
    case JobType::kNumber:
      return "a number";
    case JobType::kText:
      return "a text in quotes";
    case JobType::kFlag:
      return "true or false";
    case JobType::kNumbers:
      return "a number or a list of numbers";
    case JobType::kTexts:
      return "a list of texts in quotes";
    case JobType::kPlaces:
      return "a text in quotes or a list of landmarks, each with a place [x, y, z] for every input";
  }
  return "";
}

std::string position(const std::string& path, const toml::source_region& source) {
  return path + ":" + std::to_string(source.begin.line) + ":" + std::to_string(source.begin.column) + ": ";
}

std::string formatNumber(const toml::node& node) {
  std::ostringstream text;
  text.precision(17);
  if (const auto* integer = node.as_integer())
    text << integer->get();
  else
    text << node.as_floating_point()->get();
  return text.str();
}

/// The value as the command line would spell it; empty where it has the wrong type.
std::vector<std::string> spell(const toml::node& node, JobType type) {
  switch (type) {
    case JobType::kInteger:
      if (node.is_integer()) return {formatNumber(node)};
      break;
    case JobType::kNumber:
      if (node.is_number()) return {formatNumber(node)};
      break;
    case JobType::kText:
      if (const auto* text = node.as_string()) return {text->get()};
      break;
    case JobType::kFlag:
      if (const auto* flag = node.as_boolean()) return {flag->get() ? "true" : "false"};
      break;
    case JobType::kNumbers: {
      if (node.is_number()) return {formatNumber(node)};
      if (!node.is_array() || node.as_array()->empty()) break;
      std::string joined;
      for (const auto& item : *node.as_array()) {
        if (!item.is_number()) return {};
        joined += (joined.empty() ? "" : ",") + formatNumber(item);
      }
      return {joined};
    }
    case JobType::kTexts: {
      std::vector<std::string> texts;
      if (const auto* text = node.as_string()) return {text->get()};
      if (const auto* array = node.as_array())
        for (const auto& item : *array) {
          if (!item.is_string()) return {};
          texts.push_back(item.as_string()->get());
        }
      return texts;
    }
    case JobType::kPlaces: {
      if (const auto* text = node.as_string()) return {text->get()};
      std::string joined;
      if (const auto* marks = node.as_array())
        for (const auto& mark : *marks) {
          if (!mark.is_array()) return {};
          joined += joined.empty() ? "" : ";";
          std::string places;
          for (const auto& place : *mark.as_array()) {
            const std::vector<std::string> numbers = spell(place, JobType::kNumbers);
            if (!place.is_array() || numbers.empty()) return {};
            places += (places.empty() ? "" : "=") + numbers[0];
          }
          joined += places;
        }
      if (joined.empty()) break;
      return {joined};
    }
  }
  return {};
}

std::string readText(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  // An empty file is a job without options; streaming it would set failbit.
  if (file && file.peek() != std::ifstream::traits_type::eof()) text << file.rdbuf();
  if (!file && !file.eof()) throw IoError(path + ": cannot read the job file: " + std::strerror(errno));
  return text.str();
}

toml::table parse(const std::string& path) {
  try {
    return toml::parse(readText(path), path);
  } catch (const toml::parse_error& error) {
    throw InputError(position(path, error.source()) + std::string(error.description()));
  }
}

[[noreturn]] void throwUnknown(const std::string& path, const toml::key& key,
                               const std::vector<JobOption>& options) {
  std::string known;
  for (const JobOption& option : options) known += (known.empty() ? "" : ", ") + option.key;
  throw InputError(position(path, key.source()) + "unknown key '" + std::string(key.str()) + "'; known are " +
                   known);
}

}  // namespace

void applyJobFile(const std::string& path, const std::vector<JobOption>& options) {
  std::set<std::string> given, groups;
  for (const JobOption& option : options)
    if (option.option->count()) given.insert(option.key), groups.insert(option.group);
  groups.erase("");

  const toml::table table = parse(path);
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    const auto known = std::find_if(options.begin(), options.end(),
                                    [&](const JobOption& option) { return option.key == name; });
    if (known == options.end()) throwUnknown(path, key, options);
    const std::vector<std::string> values = spell(node, known->type);
    if (values.empty())
      throw InputError(position(path, node.source()) + "'" + name + "' must be " + describe(known->type));
    if (given.count(name) || groups.count(known->group)) continue;
    if (known->type == JobType::kFlag && values[0] == "false") continue;
    try {
      known->option->add_result(values);
      known->option->run_callback();
    } catch (const CLI::ParseError& error) {
      throw InputError(position(path, node.source()) + error.what());
    }
  }
}

}  // namespace slicemorph

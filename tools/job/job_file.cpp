#include "tools/job/job_file.h"

#include "slicemorph/errors.h"
#include "tools/job/option_values.h"
#include "tools/job/toml_reader.h"

#include <algorithm>
#include <set>

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
      return "a number, a list of numbers or a text in quotes";
    case JobType::kTexts:
      return "a list of texts in quotes";
    case JobType::kPlaces:
      return "a text in quotes or a list of landmarks, each with a place [x, y, z] for every input";
    case JobType::kTables:
      return "tables";
  }
  return "";
}

std::string spellNumber(const toml::node& node) {
  if (const auto* integer = node.as_integer()) return std::to_string(integer->get());
  return formatExactly(node.as_floating_point()->get());
}

/// The value as the command line would spell it; empty where it has the wrong type.
std::vector<std::string> spell(const toml::node& node, JobType type) {
  switch (type) {
    case JobType::kInteger:
      if (node.is_integer()) return {spellNumber(node)};
      break;
    case JobType::kNumber:
      if (node.is_number()) return {spellNumber(node)};
      break;
    case JobType::kText:
      if (const auto* text = node.as_string()) return {text->get()};
      break;
    case JobType::kFlag:
      if (const auto* flag = node.as_boolean()) return {flag->get() ? "true" : "false"};
      break;
    case JobType::kNumbers: {
      if (node.is_number()) return {spellNumber(node)};
      if (const auto* text = node.as_string()) return {text->get()};
      if (!node.is_array() || node.as_array()->empty()) break;
      std::string joined;
      for (const auto& item : *node.as_array()) {
        if (!item.is_number()) return {};
        joined += (joined.empty() ? "" : ",") + spellNumber(item);
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
          if (!mark.is_array() || mark.as_array()->size() < 2) return {};
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
    case JobType::kTables:
      break;
  }
  return {};
}

[[noreturn]] void throwUnknown(const std::string& path, const toml::key& key,
                               const std::vector<JobOption>& options) {
  std::string known;
  for (const JobOption& option : options) known += (known.empty() ? "" : ", ") + option.key;
  throw InputError(positionOf(path, key.source()) + "unknown key '" + std::string(key.str()) +
                   "'; known are " + known);
}

}  // namespace

std::string fallbackOf(double value) { return value == 0 ? "" : formatExactly(value); }

std::map<std::string, std::string> applyJobFile(const std::string& path,
                                                const std::vector<JobOption>& options) {
  std::set<std::string> given;
  for (const JobOption& option : options)
    if (option.option && option.option->count()) given.insert(option.key);
  const auto silenced = [&](const JobOption& option) {
    const auto isGiven = [&](const std::string& key) { return given.count(key) > 0; };
    return isGiven(option.key) || std::any_of(option.silencers.begin(), option.silencers.end(), isGiven);
  };

  std::map<std::string, std::string> places;
  const toml::table table = parseToml(path);
  for (const auto& [key, node] : table) {
    const std::string name(key.str()), place = positionOf(path, node.source());
    const auto known = std::find_if(options.begin(), options.end(),
                                    [&](const JobOption& option) { return option.key == name; });
    if (known == options.end()) throwUnknown(path, key, options);
    if (known->type == JobType::kTables) {
      if (!silenced(*known)) places[name] = place;
      continue;
    }
    const std::vector<std::string> values = spell(node, known->type);
    if (values.empty()) throw InputError(place + "'" + name + "' must be " + describe(known->type));
    if (silenced(*known)) continue;
    places[name] = place;
    if (known->type == JobType::kFlag && values[0] == "false") continue;
    try {
      known->option->add_result(values);
      known->option->run_callback();
    } catch (const CLI::ParseError& error) {
      throw InputError(place + error.what());
    } catch (const InputError& error) {
      throw InputError(place + error.what());
    }
  }
  return places;
}

}  // namespace slicemorph

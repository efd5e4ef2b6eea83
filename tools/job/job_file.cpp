#include "tools/job/job_file.h"

#include "slicemorph/errors.h"
#include "tools/job/option_values.h"
#include "tools/job/toml_reader.h"

#include <algorithm>

namespace slicemorph {
namespace {

const char* expectedOf(OptionType type) {
  switch (type) {
    case OptionType::kInteger:
      return "a whole number";
    case OptionType::kNumber:
      return "a number";
    case OptionType::kText:
      return "a text in quotes";
    case OptionType::kFlag:
      return "true or false";
    case OptionType::kNumbers:
      return "a number, a list of numbers or a text in quotes";
    case OptionType::kTexts:
      return "a list of texts in quotes";
    case OptionType::kLandmarks:
      return "a text in quotes or a list of landmarks, each with a place [x, y, z] for every input";
    case OptionType::kTables:
      break;
  }
  return "tables";
}

std::string spellNumber(const toml::node& node) {
  if (const auto* integer = node.as_integer()) return std::to_string(integer->get());
  return formatExactly(node.as_floating_point()->get());
}

/// Numbers joined by commas; empty where one is none.
std::string spellNumbers(const toml::array& list) {
  std::string joined;
  for (const auto& item : list) {
    if (!item.is_number()) return "";
    joined += (joined.empty() ? "" : ",") + spellNumber(item);
  }
  return joined;
}

/// `x,y,z=x,y,z;...`; empty where it is no such list.
std::string spellLandmarks(const toml::array& marks) {
  std::string joined;
  for (const auto& mark : marks) {
    if (!mark.is_array() || mark.as_array()->size() < 2) return "";
    std::string positions;
    for (const auto& position : *mark.as_array()) {
      const std::string numbers = position.is_array() ? spellNumbers(*position.as_array()) : "";
      if (numbers.empty()) return "";
      positions += (positions.empty() ? "" : "=") + numbers;
    }
    joined += (joined.empty() ? "" : ";") + positions;
  }
  return joined;
}

/// `{file = "a.obj", scale = 0.001, upright = "z"}` as the command line spells it; empty where it has other values.
std::string spellInput(const toml::table& table) {
  std::string file, braces;
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    if (!value.is_number() && !value.is_string()) return "";
    const std::string spelled = value.is_number() ? spellNumber(value) : value.as_string()->get();
    if (name == "file")
      file = spelled;
    else
      braces += (braces.empty() ? "" : ",") + name + "=" + spelled;
  }
  return file.empty() || braces.empty() ? file : file + "{" + braces + "}";
}

std::vector<std::string> spellTexts(const toml::array& list) {
  std::vector<std::string> texts;
  for (const auto& item : list) {
    const std::string text = item.is_table() ? spellInput(*item.as_table()) : "";
    if (!item.is_string() && text.empty()) return {};
    texts.push_back(item.is_string() ? item.as_string()->get() : text);
  }
  return texts;
}

/// A list as the command line would spell it; empty where it has the wrong type.
std::vector<std::string> spellList(const toml::array& list, OptionType type) {
  if (type == OptionType::kTexts) return spellTexts(list);
  const std::string joined = type == OptionType::kNumbers     ? spellNumbers(list)
                             : type == OptionType::kLandmarks ? spellLandmarks(list)
                                                              : "";
  return joined.empty() ? std::vector<std::string>() : std::vector<std::string>{joined};
}

/// The value as the command line would spell it; empty where it has the wrong type.
std::vector<std::string> spell(const toml::node& node, OptionType type) {
  const bool numeric = type == OptionType::kNumber || type == OptionType::kNumbers;
  const bool textual = type == OptionType::kText || type == OptionType::kTexts ||
                       type == OptionType::kNumbers || type == OptionType::kLandmarks;
  if (const auto* list = node.as_array()) return spellList(*list, type);
  if (const auto* flag = node.as_boolean(); flag && type == OptionType::kFlag)
    return {flag->get() ? "true" : "false"};
  if (const auto* text = node.as_string(); text && textual) return {text->get()};
  if (node.is_number() && (numeric || (type == OptionType::kInteger && node.is_integer())))
    return {spellNumber(node)};
  return {};
}

const OptionRow& rowOf(const std::string& path, const toml::key& key, const OptionSet& options) {
  std::string known;
  for (const OptionRow* row : options.rows()) {
    if (!row->inFiles) continue;
    if (row->name == key.str()) return *row;
    known += (known.empty() ? "" : ", ") + row->name;
  }
  throw InputError(positionOf(path, key.source()) + "unknown key '" + std::string(key.str()) +
                   "'; known are " + known);
}

}  // namespace

void applyJobFile(const JobFile& file, OptionSet& options) {
  const std::string& path = file.path;
  const toml::table table = parseToml(file);
  for (const auto& [key, node] : table) {
    const OptionRow& row = rowOf(path, key, options);
    const std::string source = positionOf(path, node.source());
    const bool tables = row.type == OptionType::kTables;
    const std::vector<std::string> values = tables ? std::vector<std::string>() : spell(node, row.type);
    if (!tables && values.empty())
      throw InputError(source + "'" + row.name + "' must be " + expectedOf(row.type));
    if (options.silenced(row)) continue;
    // A flag that is off counts as not given.
    if (row.type == OptionType::kFlag && values[0] == "false") continue;
    options.setSource(row.name, source);
    if (!tables) options.about(row.name, [&] { options.set(row, values); });
  }
}

}  // namespace slicemorph

#include "tools/job/toml_reader.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

namespace slicemorph {
namespace {

constexpr size_t kLongestValue = 60;  // characters of a value in messages

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string readText(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  // An empty file is a job without options; streaming it would set failbit.
  if (file && file.peek() != std::ifstream::traits_type::eof()) text << file.rdbuf();
  if (!file && !file.eof()) throw IoError(path + ": cannot read the job file: " + std::strerror(errno));
  return text.str();
}

}  // namespace

std::string positionOf(const std::string& path, const toml::source_region& source) {
  return path + ":" + std::to_string(source.begin.line) + ":" + std::to_string(source.begin.column) + ": ";
}

toml::table parseToml(const JobFile& file) {
  try {
    return toml::parse(file.text ? *file.text : readText(file.path), file.path);
  } catch (const toml::parse_error& error) {
    throw InputError(positionOf(file.path, error.source()) + std::string(error.description()));
  }
}

std::string shortText(const toml::node& node) {
  std::ostringstream stream;
  node.visit([&](const auto& value) { stream << value; });
  std::string text = stream.str();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.size() > kLongestValue ? text.substr(0, kLongestValue) + "..." : text;
}

std::string TomlReader::where(const toml::node& at) const {
  return positionOf(path_, at.source()) + (about_.empty() ? "" : about_ + ": ");
}

void TomlReader::refuse(const toml::node& at, const std::string& message) const {
  throw InputError(where(at) + message);
}

void TomlReader::checkKeys(const toml::table& table, const std::vector<std::string>& known) const {
  for (const auto& [key, node] : table) {
    if (std::count(known.begin(), known.end(), std::string(key.str()))) continue;
    throw InputError(positionOf(path_, key.source()) + (about_.empty() ? "" : about_ + ": ") +
                     "unknown key '" + std::string(key.str()) + "'; known are " + joined(known));
  }
}

std::string TomlReader::onlyOne(const toml::table& table, const std::vector<std::string>& keys) const {
  std::vector<std::string> found;
  for (const std::string& key : keys)
    if (table.contains(key)) found.push_back(key);
  if (found.size() == 1) return found[0];
  refuse(table, (found.empty() ? "has none of " + joined(keys) : "has " + joined(found)) +
                    "; give exactly one of " + joined(keys));
}

const toml::node& TomlReader::needed(const toml::table& table, const std::string& key,
                                     const std::string& example) const {
  const toml::node* node = table.get(key);
  if (!node) refuse(table, "has no " + key + "; expected for example " + example);
  return *node;
}

const toml::table& TomlReader::table(const toml::node& node, const std::string& what,
                                     const std::string& example) const {
  if (!node.is_table())
    refuse(node, what + " " + shortText(node) + ": expected a table, for example " + example);
  return *node.as_table();
}

const toml::array& TomlReader::array(const toml::node& node, const std::string& what,
                                     const std::string& example) const {
  if (!node.is_array())
    refuse(node, what + " " + shortText(node) + ": expected a list, for example " + example);
  return *node.as_array();
}

const toml::array& TomlReader::perInput(const toml::node& node, const std::string& what,
                                        size_t inputs) const {
  const toml::array& list = array(node, what, "[...] with one item per input");
  if (list.size() != inputs)
    refuse(node, what + " has " + std::to_string(list.size()) + " items for " + std::to_string(inputs) +
                     " inputs; give one per input");
  return list;
}

std::string TomlReader::text(const toml::node& node, const std::string& what) const {
  if (!node.is_string()) refuse(node, what + " " + shortText(node) + " must be a text in quotes");
  return node.as_string()->get();
}

double TomlReader::number(const toml::node& node, const std::string& what) const {
  const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value))
    refuse(node, what + " " + shortText(node) + " must be a finite number");
  return *value;
}

std::vector<double> TomlReader::numbers(const toml::node& node, const std::string& what) const {
  std::vector<double> values;
  for (const toml::node& item : array(node, what, "[0.5, 0.5]")) values.push_back(number(item, what));
  return values;
}

Vec3d TomlReader::vector(const toml::node& node, const std::string& what) const {
  const toml::array& items = array(node, what, "[0.1, 0.2, 0.3]");
  if (items.size() != 3) refuse(node, what + " " + shortText(node) + " must be three numbers, [x, y, z]");
  return {number(items[0], what), number(items[1], what), number(items[2], what)};
}

}  // namespace slicemorph

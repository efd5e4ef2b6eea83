#include "tools/job/job_writer.h"

#include "slicemorph/errors.h"
#include "tools/job/input_names.h"
#include "tools/job/option_values.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cstdio>
#include <sstream>

namespace slicemorph {
namespace {

constexpr size_t kCommentWidth = 100;  // columns

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    char code[8];
    std::snprintf(code, sizeof code, "\\u%04X", static_cast<unsigned char>(c));
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    result += control ? std::string(code) : c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  }
  return result + "\"";
}

std::string tomlList(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
  return "[" + text + "]";
}

std::string tomlOfVector(const Vec3d& v) { return tomlOf(std::vector<double>{v[0], v[1], v[2]}); }

/// One number as a number, several that are separated by commas as a list, anything else as a text.
std::string numbersOrText(const std::string& text) {
  try {
    const std::vector<double> numbers = parseNumbers("", text);
    return numbers.size() == 1 ? formatExactly(numbers[0]) : tomlOf(numbers);
  } catch (const InputError&) {
    return quoted(text);
  }
}

/// Landmarks, `x,y,z=x,y,z;...` on the command line, as lists; names of files as a text.
std::string landmarksOrText(const std::string& text) {
  if (text.find('=') == std::string::npos) return quoted(text);
  std::vector<std::string> marks;
  for (const std::string& mark : parted(text, ';')) {
    std::vector<std::string> positions;
    for (const std::string& position : parted(mark, '=')) positions.push_back(numbersOrText(position));
    marks.push_back(tomlList(positions));
  }
  return tomlList(marks);
}

/// The TOML form of a value that these texts give on the command line.
std::string valueOf(const OptionRow& row, const std::vector<std::string>& texts) {
  const std::string& text = texts.back();
  switch (row.type) {
    case OptionType::kFlag:
      return text;
    case OptionType::kInteger:
    case OptionType::kNumber:
    case OptionType::kNumbers:
      return numbersOrText(text);
    case OptionType::kLandmarks:
      return landmarksOrText(text);
    case OptionType::kTexts: {
      std::vector<std::string> items;
      items.reserve(texts.size());
      for (const std::string& each : texts) items.push_back(quoted(each));
      return tomlList(items);
    }
    default:
      return quoted(text);
  }
}

std::string comment(const std::string& text) {
  std::string lines, line = "#";
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (line.size() + 1 + word.size() > kCommentWidth) lines += line + "\n", line = "#";
    line += " " + word;
  }
  return lines + line + "\n";
}

/// An option's lines: its help as a comment, then its value if it was given, else its default as a comment.
std::string describe(const OptionRow& row, const OptionSet& options, const JobTables& tables) {
  const std::string form = formOf(row);
  const std::string text = comment(helpOf(row) + (form.empty() ? "" : " [" + form + "]"));
  const auto value = tables.values.find(row.name);
  if (value != tables.values.end()) return text + row.name + " = " + value->second + "\n";
  const std::vector<std::string> given = options.texts(row.name);
  if (!given.empty()) return text + row.name + " = " + valueOf(row, given) + "\n";
  const std::string fallback = row.type == OptionType::kFlag ? "false" : defaultOf(row);
  return text + "# " + row.name + " =" + (fallback.empty() ? "" : " " + valueOf(row, {fallback})) + "\n";
}

std::string describe(const std::vector<WeightKey>& keys, const std::vector<std::string>& inputs) {
  std::string text;
  for (const WeightKey& key : keys) {
    const auto all = std::find(key.weights.begin(), key.weights.end(), 1.0);
    const bool one =
        all != key.weights.end() &&
        std::count(key.weights.begin(), key.weights.end(), 0.0) + 1 == std::ptrdiff_t(key.weights.size());
    text += "  {at = " + formatExactly(key.at) + ", ";
    text += one ? "input = " + quoted(nameOfInput(size_t(all - key.weights.begin()), inputs))
                : "weights = " + tomlOf(key.weights);
    text += "},\n";
  }
  return "[\n" + text + "]";
}

std::string describe(const Feature& feature) {
  std::vector<std::string> items;
  for (size_t k = 0; k < feature.positions.size(); ++k) {
    std::vector<std::string> positions;
    for (const Vec3d& position : feature.positions[k]) positions.push_back(tomlOfVector(position));
    if (feature.kind == Feature::Kind::kPoint)
      items.push_back(positions[0]);
    else if (feature.kind == Feature::Kind::kLine)
      items.push_back(tomlList(positions));
    else
      items.push_back("{center = " + positions[0] + ", normal = " + tomlOfVector(feature.normals[k]) +
                      ", radius = " + formatExactly(feature.radii[k]) + "}");
  }
  const char* kind = feature.kind == Feature::Kind::kPoint  ? "point"
                     : feature.kind == Feature::Kind::kLine ? "line"
                                                            : "disk";
  return "\n[[feature]]\nname = " + quoted(feature.name) + "\n" + kind + " = " + tomlList(items) + "\n";
}

std::string describe(const Region& region, const std::vector<std::string>& inputs) {
  std::string text = "\n[[region]]\nname = " + quoted(region.name) +
                     "\non = " + quoted(nameOfInput(region.object, inputs)) + "\n";
  if (region.kind == Region::Kind::kSphere)
    text += "sphere = {center = " + tomlOfVector(region.center) +
            ", radius = " + formatExactly(region.radius) + "}\n";
  else if (region.kind == Region::Kind::kBox)
    text += "box = {min = " + tomlOfVector(region.box.min()) + ", max = " + tomlOfVector(region.box.max()) +
            "}\n";
  else
    text += "spine = " + tomlOf(std::vector<double>{region.from, region.to}) + "\n";
  return text + "border = " + formatExactly(region.border) + "\nweights = " + tomlOf(region.weights) + "\n";
}

constexpr const char* kNoFeature = R"(
# Places that all inputs have, one per input: a point, a line or a disk.
# [[feature]]
# name = "nose"
# point = [[x, y, z], [x, y, z]]
# line = [[[x, y, z], [x, y, z]], [[x, y, z], [x, y, z]]]
# disk = [{center = [x, y, z], normal = [x, y, z], radius = r}, {center = [x, y, z], normal = [x, y, z], radius = r}]
)";
constexpr const char* kNoRegion = R"(
# Parts with weights of their own: a sphere, a box or a stretch of the spine on one input.
# [[region]]
# name = "head"
# on = "a"
# sphere = {center = [x, y, z], radius = r}
# box = {min = [x, y, z], max = [x, y, z]}
# spine = [0, 0.4]
# border = 0.2  # world units over which weights go over; 0: a tenth of the size
# weights = [0, 1]
)";

constexpr const char* kJobHead =
    "# Job of: slicemorph morph --config FILE. What the command line says wins.\n";

/// Throws InputError where a text is no job file. `said`: what it is for.
void checkToml(const std::string& text, const std::string& said) {
  try {
    (void)toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw InputError(said +
                     ": a job file cannot hold one of these names: " + std::string(error.description()));
  }
}

}  // namespace

std::string tomlOf(const std::vector<double>& numbers) {
  std::vector<std::string> items;
  items.reserve(numbers.size());
  for (const double number : numbers) items.push_back(formatExactly(number));
  return tomlList(items);
}

std::string tomlOf(const std::vector<std::vector<Vec3d>>& landmarks) {
  std::vector<std::string> marks;
  for (const std::vector<Vec3d>& landmark : landmarks) {
    std::vector<std::string> positions;
    for (const Vec3d& position : landmark) positions.push_back(tomlOfVector(position));
    marks.push_back(tomlList(positions));
  }
  return tomlList(marks);
}

std::string givenJobText(const OptionSet& options, const JobTables& tables) {
  std::string text = kJobHead;
  std::map<std::string, std::string> values = tables.values;
  if (!tables.keys.empty()) values["keys"] = describe(tables.keys, tables.inputs);
  for (const OptionRow* row : options.rows()) {
    if (!row->inFiles || !row->field) continue;
    const auto value = values.find(row->name);
    const std::vector<std::string> given = options.texts(row->name);
    if (value != values.end())
      text += row->name + " = " + value->second + "\n";
    else if (!given.empty())
      text += row->name + " = " + valueOf(*row, given) + "\n";
  }
  for (const Feature& feature : tables.features) text += describe(feature);
  for (const Region& region : tables.regions) text += describe(region, tables.inputs);
  checkToml(text, "the job");
  return text;
}

std::string jobText(const OptionSet& options, const JobTables& tables) {
  std::string text = kJobHead;
  JobTables all = tables;
  if (!tables.keys.empty()) all.values["keys"] = describe(tables.keys, tables.inputs);
  for (const OptionRow* row : options.rows())
    if (row->inFiles && row->field) text += "\n" + describe(*row, options, all);
  for (const Feature& feature : tables.features) text += describe(feature);
  if (tables.features.empty()) text += kNoFeature;
  for (const Region& region : tables.regions) text += describe(region, tables.inputs);
  if (tables.regions.empty()) text += kNoRegion;
  checkToml(text, "--print-config");
  return text;
}

}  // namespace slicemorph

#include "tools/job/guidance_file.h"

#include "slicemorph/errors.h"
#include "tools/job/input_names.h"
#include "tools/job/option_values.h"
#include "tools/job/toml_reader.h"

namespace slicemorph {
namespace {

using InputTexts = std::vector<std::string>;

/// The tables [[kind]] of a file; none where it has none.
std::vector<const toml::table*> tablesOf(const toml::table& root, const std::string& kind,
                                         const TomlReader& read) {
  std::vector<const toml::table*> tables;
  const toml::node* node = root.get(kind);
  if (!node) return tables;
  if (!node->is_array()) read.refuse(*node, "'" + kind + "' must be tables, each headed [[" + kind + "]]");
  for (const toml::node& item : *node->as_array())
    tables.push_back(&read.table(item, kind, "[[" + kind + "]]"));
  return tables;
}

/// A table's name, or kind and number (`feature 1`) where it has none; sets what messages are
/// about (`feature 'nose'`).
std::string nameOf(const toml::table& table, const std::string& kind, size_t number, TomlReader& read) {
  std::string name = kind + " " + std::to_string(number);
  read.setAbout(name);
  const toml::node* node = table.get("name");
  if (node) name = read.text(*node, "name");
  read.setAbout(node ? kind + " '" + name + "'" : name);
  return name;
}

double positive(const toml::node& node, const std::string& what, const TomlReader& read) {
  const double value = read.number(node, what);
  if (!(value > 0)) read.refuse(node, what + " " + shortText(node) + " must be above 0, in world units");
  return value;
}

size_t inputOf(const toml::node& node, const std::string& what, const InputTexts& inputs,
               const TomlReader& read) {
  try {
    return inputNamed(read.text(node, what), inputs);
  } catch (const InputError& error) {
    if (!node.is_string()) throw;
    read.refuse(node, what + " = " + error.what());
  }
}

/// `weights = [...]` or `input = "..."` of a table.
Weights weightsOf(const toml::table& table, const InputTexts& inputs, TomlReader& read) {
  const std::string key = read.onlyOne(table, {"weights", "input"});
  const toml::node& node = *table.get(key);
  if (key == "weights") {
    const std::string said = read.where(node) + "weights " + shortText(node);
    const CheckedWeights checked = checkWeights(said, read.numbers(node, key), inputs.size());
    if (!checked.note.empty()) read.addNote({"job.weights-normalised", Severity::kNote, "", checked.note});
    return checked.weights;
  }
  Weights weights(inputs.size(), 0.0);
  weights[inputOf(node, key, inputs, read)] = 1;
  return weights;
}

/// Two or more points along a line.
std::vector<Vec3d> lineOf(const toml::node& node, const std::string& what, const TomlReader& read) {
  std::vector<Vec3d> points;
  for (const toml::node& point : read.array(node, what, "[[0, 0, 0], [0, 0, 1]]"))
    points.push_back(read.vector(point, what));
  if (points.size() < 2)
    read.refuse(node, what + " has " + std::to_string(points.size()) + " places; a line needs two or more");
  double length = 0;
  for (size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).length();
  if (length == 0) read.refuse(node, what + " has no length; its places must differ");
  return points;
}

void addDisk(Feature& feature, const toml::node& node, const std::string& what, const TomlReader& read) {
  const std::string example = "{center = [0, 0, 0], normal = [0, 0, 1], radius = 1}";
  const toml::table& disk = read.table(node, what, example);
  read.checkKeys(disk, {"center", "normal", "radius"});
  const toml::node& normal = read.needed(disk, "normal", example);
  feature.positions.push_back({read.vector(read.needed(disk, "center", example), what + ": center")});
  feature.normals.push_back(read.vector(normal, what + ": normal"));
  if (feature.normals.back().length() == 0)
    read.refuse(normal, what + ": normal " + shortText(normal) + " has no length; give a direction");
  feature.radii.push_back(positive(read.needed(disk, "radius", example), what + ": radius", read));
}

Feature featureOf(const toml::table& table, size_t number, const InputTexts& inputs, TomlReader& read) {
  Feature feature;
  feature.name = nameOf(table, "feature", number, read);
  read.checkKeys(table, {"name", "point", "line", "disk"});
  const std::string kind = read.onlyOne(table, {"point", "line", "disk"});
  feature.kind = kind == "point"  ? Feature::Kind::kPoint
                 : kind == "line" ? Feature::Kind::kLine
                                  : Feature::Kind::kDisk;
  size_t input = 0;
  for (const toml::node& item : read.perInput(*table.get(kind), kind, inputs.size())) {
    const std::string what = kind + " of input " + std::to_string(++input);
    if (kind == "point")
      feature.positions.push_back({read.vector(item, what)});
    else if (kind == "line")
      feature.positions.push_back(lineOf(item, what, read));
    else
      addDisk(feature, item, what, read);
  }
  return feature;
}

void setSphere(Region& region, const toml::node& node, const TomlReader& read) {
  const std::string example = "{center = [0, 0, 0], radius = 1}";
  const toml::table& sphere = read.table(node, "sphere", example);
  read.checkKeys(sphere, {"center", "radius"});
  region.kind = Region::Kind::kSphere;
  region.center = read.vector(read.needed(sphere, "center", example), "sphere: center");
  region.radius = positive(read.needed(sphere, "radius", example), "sphere: radius", read);
}

void setBox(Region& region, const toml::node& node, const TomlReader& read) {
  const std::string example = "{min = [0, 0, 0], max = [1, 1, 1]}";
  const toml::table& box = read.table(node, "box", example);
  read.checkKeys(box, {"min", "max"});
  const toml::node &min = read.needed(box, "min", example), &max = read.needed(box, "max", example);
  region.kind = Region::Kind::kBox;
  region.box = openvdb::BBoxd(read.vector(min, "box: min"), read.vector(max, "box: max"));
  for (int d = 0; d < 3; ++d)
    if (!(region.box.min()[d] < region.box.max()[d]))
      read.refuse(max,
                  "box: max " + shortText(max) + " must be above min " + shortText(min) + " along all axes");
}

void setStretch(Region& region, const toml::node& node, const TomlReader& read) {
  const std::vector<double> ends = read.numbers(node, "spine");
  if (ends.size() != 2 || !(0 <= ends[0] && ends[0] < ends[1] && ends[1] <= 1))
    read.refuse(
        node, "spine " + shortText(node) + " must be [FROM, TO], shares of the length: 0 <= FROM < TO <= 1");
  region.kind = Region::Kind::kSpine;
  region.from = ends[0], region.to = ends[1];
}

Region regionOf(const toml::table& table, size_t number, const InputTexts& inputs, TomlReader& read) {
  Region region;
  region.name = nameOf(table, "region", number, read);
  read.checkKeys(table, {"name", "on", "sphere", "box", "spine", "border", "weights", "input"});
  const std::string kind = read.onlyOne(table, {"sphere", "box", "spine"});
  const toml::node& shape = *table.get(kind);
  kind == "sphere" ? setSphere(region, shape, read)
  : kind == "box"  ? setBox(region, shape, read)
                   : setStretch(region, shape, read);
  if (const toml::node* on = table.get("on")) region.object = inputOf(*on, "on", inputs, read);
  if (const toml::node* border = table.get("border")) {
    region.border = read.number(*border, "border");
    if (region.border < 0)
      read.refuse(*border, "border " + shortText(*border) + " must be 0 or more, in world units");
  }
  region.weights = weightsOf(table, inputs, read);
  return region;
}

WeightKey keyOf(const toml::node& node, const WeightKey* before, const InputTexts& inputs, TomlReader& read) {
  const std::string example = "{at = 0.5, input = \"a\"} or {at = 0.5, weights = [...]}";
  const toml::table& table = read.table(node, "key", example);
  read.checkKeys(table, {"at", "input", "weights"});
  const toml::node& at = read.needed(table, "at", example);
  const double time = read.number(at, "at");
  const std::string fault = faultOfTime(time, before);
  if (!fault.empty()) read.refuse(at, fault);
  return {time, weightsOf(table, inputs, read)};
}

}  // namespace

Guidance readGuidance(const JobFile& file, const InputTexts& inputs) {
  const toml::table root = parseToml(file);
  TomlReader read(file.path);
  Guidance guidance;
  for (const toml::table* table : tablesOf(root, "feature", read))
    guidance.features.push_back(featureOf(*table, guidance.features.size() + 1, inputs, read));
  read.setAbout("");
  for (const toml::table* table : tablesOf(root, "region", read))
    guidance.regions.push_back(regionOf(*table, guidance.regions.size() + 1, inputs, read));
  guidance.notes = read.notes();
  return guidance;
}

KeyList readKeys(const JobFile& file, const InputTexts& inputs) {
  const toml::table root = parseToml(file);
  TomlReader read(file.path);
  KeyList list;
  const toml::node* node = root.get("keys");
  if (!node) return list;
  if (const auto* text = node->as_string()) {
    list.keys = parseKeys(read.where(*node) + "keys", text->get(), inputs);
    return list;
  }
  if (!node->is_array() || node->as_array()->empty())
    read.refuse(*node, "'keys' must be a text, \"a@0 b@1\", or a list of {at = 0, input = \"a\"}");
  for (const toml::node& item : *node->as_array()) {
    read.setAbout("key " + std::to_string(list.keys.size() + 1));
    const WeightKey* before = list.keys.empty() ? nullptr : &list.keys.back();
    list.keys.push_back(keyOf(item, before, inputs, read));
  }
  list.notes = read.notes();
  return list;
}

}  // namespace slicemorph

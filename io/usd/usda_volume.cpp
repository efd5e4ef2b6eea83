#include "io/usd/usda_volume.h"

#include "engine/volume/surface_colors.h"
#include "io/atomic_file.h"
#include "io/vdb/grid_box.h"
#include "io/vdb/vector_parts.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/vdb_reader.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;
using openvdb::GridBase;

/// A grid as hosts look it up: its name, and its index among those of that name in a file.
using FieldKey = std::pair<std::string, int>;

struct Field {
  FieldKey key;
  std::string dataType;  ///< empty: USD has no word for it
  std::string role, gridClass;
};

/// What a file holds.
struct FileFields {
  bool there = false;
  std::vector<Field> fields;
  openvdb::BBoxd box;  ///< world, of all active voxels
};

/// `fieldDataType`, by the names of OpenVDB's types.
const std::map<std::string, std::string> kDataTypes = {
    {"float", "float"},   {"double", "double"}, {"int32", "int"}, {"int64", "int64"}, {"vec3s", "float3"},
    {"vec3d", "double3"}, {"vec3i", "int3"},    {"bool", "bool"}, {"mask", "mask"},   {"string", "string"}};

/// `vectorDataRoleHint`: how a vector turns with its volume.
std::string roleOf(const GridBase& grid) {
  if (grid.valueType().rfind("vec3", 0) != 0) return "None";
  if (isColorName(grid.getName())) return "Color";
  switch (grid.getVectorType()) {
    case openvdb::VEC_COVARIANT:
    case openvdb::VEC_COVARIANT_NORMALIZE:
      return "Normal";
    case openvdb::VEC_CONTRAVARIANT_RELATIVE:
      return "Vector";
    case openvdb::VEC_CONTRAVARIANT_ABSOLUTE:
      return "Point";
    default:  // also what nothing was said of
      return isVelocityName(grid.getName()) ? "Vector" : "None";
  }
}

std::string classOf(const GridBase& grid) {
  switch (grid.getGridClass()) {
    case openvdb::GRID_LEVEL_SET:
      return "levelSet";
    case openvdb::GRID_FOG_VOLUME:
      return "fogVolume";
    case openvdb::GRID_STAGGERED:
      return "staggered";
    default:
      return "unknown";
  }
}

Field fieldOf(const GridBase& grid, int index) {
  const auto type = kDataTypes.find(grid.valueType());
  return {{grid.getName(), index}, type == kDataTypes.end() ? "" : type->second, roleOf(grid), classOf(grid)};
}

FileFields fieldsOf(const std::string& path) {
  FileFields found;
  std::error_code error;
  if (!fs::exists(path, error)) return found;
  const VdbFile file(path);
  std::map<std::string, int> ofName;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const GridBase::Ptr header = file.readHeader(i);
    if (!header) continue;
    found.fields.push_back(fieldOf(*header, ofName[header->getName()]++));
    const openvdb::CoordBBox voxels = activeBoxIn(file, i, *header);
    if (voxels.empty()) continue;
    // Out to the voxels' faces.
    found.box.expand(header->transform().indexToWorld(
        openvdb::BBoxd(voxels.min().asVec3d() - Vec3d(0.5), voxels.max().asVec3d() + Vec3d(0.5))));
  }
  found.there = true;
  return found;
}

/// Tells whether files came, went or were written anew.
std::vector<std::pair<std::uintmax_t, fs::file_time_type>> stateOf(const std::vector<UsdaFrame>& frames) {
  std::vector<std::pair<std::uintmax_t, fs::file_time_type>> state;
  for (const UsdaFrame& frame : frames) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(frame.path, error);
    state.emplace_back(size, fs::last_write_time(frame.path, error));
  }
  return state;
}

/// The fields of all files, in the order in which they first appear; each as the first file has it.
std::vector<Field> allFields(const std::vector<FileFields>& files) {
  std::vector<Field> all;
  for (const FileFields& file : files)
    for (const Field& field : file.fields)
      if (std::none_of(all.begin(), all.end(), [&](const Field& f) { return f.key == field.key; }))
        all.push_back(field);
  return all;
}

bool has(const FileFields& file, const FieldKey& key) {
  return std::any_of(file.fields.begin(), file.fields.end(),
                     [&](const Field& field) { return field.key == key; });
}

/// Names of the fields' prims: no two are the same, whatever the grids' names become.
std::vector<std::string> primNames(const std::vector<Field>& fields) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const Field& field : fields) {
    const std::string first = usdaName(field.key.first);
    std::string name = first;
    for (int n = 2; !taken.insert(name).second; ++n) name = first + "_" + std::to_string(n);
    names.push_back(name);
  }
  return names;
}

std::string fieldText(const std::string& prim, const Field& field, const std::vector<UsdaFrame>& frames,
                      const std::vector<FileFields>& files) {
  std::string text = "\n        def OpenVDBAsset \"" + prim + "\"\n        {\n";
  const auto line = [&](const std::string& said) { text += "            " + said + "\n"; };
  line("token fieldClass = " + usdaString(field.gridClass));
  if (!field.dataType.empty()) line("token fieldDataType = " + usdaString(field.dataType));
  line("int fieldIndex = " + std::to_string(field.key.second));
  line("token fieldName = " + usdaString(field.key.first));
  line("asset filePath.timeSamples = {");
  for (size_t i = 0; i < frames.size(); ++i) {
    const bool lacks = files[i].there && !has(files[i], field.key);
    line("    " + std::to_string(frames[i].number) + ": " +
         (lacks ? "None" : usdaAsset(fs::path(frames[i].path).filename().string())) + ",");
  }
  line("}");
  line("token vectorDataRoleHint = " + usdaString(field.role));
  return text + "        }\n";
}

std::string extentText(const std::vector<UsdaFrame>& frames, const std::vector<FileFields>& files) {
  std::string text = "        float3[] extent.timeSamples = {\n";
  for (size_t i = 0; i < frames.size(); ++i)
    if (files[i].there)
      text += "            " + std::to_string(frames[i].number) + ": " + usdaExtent(files[i].box) + ",\n";
  return text + "        }\n";
}

std::string volumeText(const std::string& path, const std::vector<UsdaFrame>& frames,
                       const UsdaStage& stage) {
  std::vector<FileFields> files;
  files.reserve(frames.size());
  for (const UsdaFrame& frame : frames) files.push_back(fieldsOf(frame.path));
  const std::vector<Field> fields = allFields(files);
  const std::vector<std::string> prims = primNames(fields);
  const std::string name = usdaNameOfFile(path);
  std::string text = usdaHeader(stage, name, std::pair(frames.front().number, frames.back().number)) +
                     "def Xform \"" + name +
                     "\" (\n    kind = \"component\"\n)\n{\n    def Volume \"volume\"\n    {\n" +
                     extentText(frames, files);
  for (const std::string& prim : prims)
    text += "        rel field:" + prim + " = </" + name + "/volume/" + prim + ">\n";
  for (size_t i = 0; i < fields.size(); ++i) text += fieldText(prims[i], fields[i], frames, files);
  return text + "    }\n}\n";
}

}  // namespace

void writeUsdaVolume(const std::string& path, const std::vector<UsdaFrame>& frames, const UsdaStage& stage) {
  // Again where another process has finished a frame meanwhile: of those that end at the same time the one that writes
  // last may have looked first.
  auto before = stateOf(frames);
  for (bool changed = true; changed;) {
    writeTextFile(path, volumeText(path, frames, stage));
    auto now = stateOf(frames);
    changed = now != before;
    before = std::move(now);
  }
}

}  // namespace slicemorph

#include "io/mesh/obj_materials.h"

#include "io/mesh/mesh_text.h"
#include "io/whole_file.h"

#include <filesystem>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;
using openvdb::math::Vec3s;

/// The .mtl files that a `mtllib` line names (see readMaterialColors), without those that are
/// missing or empty.
std::vector<std::string> filesOf(const std::string& objPath, const std::string& named) {
  const auto isThere = [](const fs::path& path) {
    std::error_code error;
    return fs::is_regular_file(path, error) && fs::file_size(path, error) > 0 && !error;
  };
  const fs::path folder = fs::path(objPath).parent_path();
  if (isThere(folder / named)) return {(folder / named).string()};
  std::vector<std::string> files;
  Text tokens(named);
  for (std::string_view token = tokens.token(); !token.empty(); token = tokens.token())
    if (isThere(folder / token)) files.push_back((folder / token).string());
  return files;
}

/// Parses what follows `Kd`: `r g b`, or `r` for a grey. False for colours given as spectra or CIE XYZ.
bool readColor(Text tokens, Vec3s& color) {
  if (!parse(tokens.token(), color[0])) return false;
  const std::string_view second = tokens.token();
  if (second.empty()) {
    color[1] = color[2] = color[0];
    return true;
  }
  return parse(second, color[1]) && parse(tokens.token(), color[2]);
}

void readMaterials(const std::string& path, MaterialColors& colors) {
  const std::string bytes = readWholeFile(path);
  std::string material;
  Text text(bytes);
  while (!text.done()) {
    Text tokens(text.line());
    const std::string_view kind = tokens.token();
    if (kind == "newmtl") material = trimmed(tokens.rest());
    Vec3s color;
    if (kind != "Kd" || !readColor(tokens, color)) continue;
    if (!isFinite(color))
      refuse(path, "line " + std::to_string(text.lineNumber()) + ": the colour is not finite (" +
                       std::string(trimmed(tokens.rest())) + ")");
    colors[material] = color;
  }
}

}  // namespace

MaterialColors readMaterialColors(const std::string& objPath, const std::vector<std::string>& named) {
  MaterialColors colors;
  for (const std::string& names : named)
    for (const std::string& file : filesOf(objPath, names)) readMaterials(file, colors);
  return colors;
}

}  // namespace slicemorph

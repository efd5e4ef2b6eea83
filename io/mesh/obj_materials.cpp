#include "io/mesh/obj_materials.h"

#include "io/mesh/mesh_text.h"
#include "io/whole_file.h"

#include <algorithm>
#include <filesystem>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;
using openvdb::Vec3s;

/// The .mtl files that a `mtllib` line names (see readMaterialColors), without those that are
/// missing or empty.
std::vector<std::string> filesOf(const std::string& objPath, const std::string& named) {
  const auto isThere = [](const fs::path& path) {
    std::error_code error;
    return fs::is_regular_file(path, error) && fs::file_size(path, error) > 0 && !error;
  };
  const fs::path folder = fs::path(objPath).parent_path();
  std::string slashed = named;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');  // as Windows writes paths
  for (const std::string& whole : {named, slashed})
    if (isThere(folder / whole)) return {(folder / whole).string()};
  std::vector<std::string> files;
  Text tokens(slashed);
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

/// Number of arguments of an option of map_Kd; -o, -s and -t have up to three numbers (below 0). 0: no option.
int argumentsOf(std::string_view option) {
  static const std::map<std::string_view, int> kArguments{
      {"-blendu", 1}, {"-blendv", 1},     {"-bm", 1},      {"-boost", 1}, {"-cc", 1},
      {"-clamp", 1},  {"-colorspace", 1}, {"-imfchan", 1}, {"-mm", 2},    {"-texres", 1},
      {"-type", 1},   {"-o", -3},         {"-s", -3},      {"-t", -3}};
  const auto found = kArguments.find(option);
  return found == kArguments.end() ? 0 : found->second;
}

/// The picture's file in the folder of the .mtl: by its path, else by its name alone (paths of another machine).
std::string pictureFile(const std::string& mtl, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const fs::path folder = fs::path(mtl).parent_path(), whole = folder / name;
  std::error_code error;
  const fs::path alone = folder / fs::path(name).filename();
  return (!fs::exists(whole, error) && fs::exists(alone, error) ? alone : whole).string();
}

/// Parses what follows `map_Kd`: options, then the picture's name, which may have spaces.
ObjTexture readTexture(const std::string& mtl, std::string_view text) {
  ObjTexture texture;
  std::string_view rest = trimmed(text);
  for (Text words(rest); !rest.empty(); rest = trimmed(words.rest())) {
    const std::string option = lowerCase(words.token());
    const int arguments = argumentsOf(option);
    if (arguments == 0) break;
    openvdb::Vec3d numbers(option == "-s" ? 1.0 : 0.0);
    for (int i = 0; i < std::abs(arguments); ++i) {
      Text ahead = words;
      const std::string_view word = ahead.token();
      const std::optional<double> number = wholeNumber(word);
      if (arguments < 0 && !number) break;
      if (number) numbers[i] = *number;
      if (option == "-clamp" && lowerCase(word) == "on")
        texture.sampling.u = texture.sampling.v = TextureWrap::kClamp;
      words = ahead;
    }
    if (option == "-s") texture.scale = {numbers[0], numbers[1]};
    if (option == "-o") texture.offset = {numbers[0], numbers[1]};
  }
  if (!rest.empty()) texture.file = pictureFile(mtl, std::string(rest));
  return texture;
}

void readMaterials(const std::string& path, ObjMaterials& materials) {
  const std::string bytes = readWholeFile(path);
  std::string memory;
  ObjMaterial* material = nullptr;
  Text text(plainText(bytes, memory));
  while (!text.done()) {
    Text tokens(text.line());
    const std::string kind = lowerCase(tokens.token());
    if (kind == "newmtl") {
      material = &materials[std::string(trimmed(tokens.rest()))];
      *material = {};
    }
    if (!material) continue;
    if (kind == "map_kd") material->texture = readTexture(path, tokens.rest());
    Vec3s color;
    if (kind != "kd" || !readColor(tokens, color)) continue;
    if (!isFinite(color))
      refuse(path, "line " + std::to_string(text.lineNumber()) + ": the colour is not finite (" +
                       std::string(trimmed(tokens.rest())) + ")");
    material->color = color;
  }
}

}  // namespace

ObjMaterials readObjMaterials(const std::string& objPath, const std::vector<std::string>& named) {
  ObjMaterials materials;
  for (const std::string& names : named)
    for (const std::string& file : filesOf(objPath, names)) readMaterials(file, materials);
  return materials;
}

}  // namespace slicemorph

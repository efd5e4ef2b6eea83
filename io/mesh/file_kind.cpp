#include "io/mesh/file_kind.h"

#include "io/mesh/mesh_text.h"

#include <cstring>

namespace slicemorph {
namespace {

struct Signature {
  std::string_view bytes;  ///< at `offset`
  size_t offset;
  const char *name, *extension;
};

using namespace std::string_view_literals;

/// First bytes of formats, from their specifications.
constexpr Signature kSignatures[] = {
    {"\x89PNG\r\n\x1a\n"sv, 0, "a PNG picture", ""},
    {"\xff\xd8\xff"sv, 0, "a JPEG picture", ""},
    {"GIF87a"sv, 0, "a GIF picture", ""},
    {"GIF89a"sv, 0, "a GIF picture", ""},
    {"II*\0"sv, 0, "a TIFF picture", ""},
    {"MM\0*"sv, 0, "a TIFF picture", ""},
    {"v/1\x01"sv, 0, "an OpenEXR picture", ""},
    {"RIFF"sv, 0, "a RIFF file (a picture or a film)", ""},
    {"PK\x03\x04"sv, 0, "a ZIP archive (as .zip, .3mf, .usdz)", ""},
    {"\x1f\x8b"sv, 0, "compressed with gzip", ""},
    {"BZh"sv, 0, "compressed with bzip2", ""},
    {"\xfd"
     "7zXZ\0"sv,
     0, "compressed with xz", ""},
    {"\x28\xb5\x2f\xfd"sv, 0, "compressed with zstd", ""},
    {"7z\xbc\xaf\x27\x1c"sv, 0, "a 7z archive", ""},
    {"%PDF-"sv, 0, "a PDF document", ""},
    {"Kaydara FBX"sv, 0, "an FBX file", ""},
    {"; FBX"sv, 0, "an FBX file", ""},
    {"BLENDER"sv, 0, "a Blender file", ""},
    {"PXR-USDC"sv, 0, "a USD file", ""},
    {"#usda"sv, 0, "a USD file", ""},
    {" BDV"sv, 0, "an OpenVDB file", ".vdb"},
    {"NRRD0"sv, 0, "an NRRD image", ".nrrd"},
    {"DICM"sv, 128, "a DICOM file", ".dcm"},
    {"n+1\0"sv, 344, "a NIfTI image", ".nii"},
    {"# vtk DataFile"sv, 0, "a VTK file", ""},
    {"#VRML"sv, 0, "a VRML file", ""},
    {"ISO-10303-21"sv, 0, "a STEP file", ""},
    {"version https://git-lfs"sv, 0, "a Git LFS pointer, not the file itself (`git lfs pull` fetches it)",
     ""},
    {"<!doctype html"sv, 0, "a web page", ""},
    {"<html"sv, 0, "a web page", ""},
    {"<?xml"sv, 0, "an XML file", ""},
    {"glTF"sv, 0, "a binary glTF file", ".glb"},
};

/// Whether the first lines with words are those of an OBJ: a vertex of three numbers is among the first 200.
bool looksLikeObj(std::string_view bytes) {
  constexpr int kLines = 200;
  Text text(bytes);
  for (int i = 0; i < kLines && !text.done(); ++i) {
    Text words(text.line());
    const std::string_view kind = words.token();
    if (kind != "v") continue;
    int numbers = 0;
    while (wholeNumber(words.token())) ++numbers;
    return numbers >= 3;
  }
  return false;
}

}  // namespace

bool isWholeStl(std::string_view bytes) {
  if (bytes.size() < 84) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return bytes.size() == 84 + 50 * std::uint64_t(count);
}

FileKind kindOfFile(std::string_view bytes) {
  std::string memory;
  const std::string_view text = plainText(bytes, memory);
  const std::string start = lowerCase(trimmed(text.substr(0, 256)));
  for (const Signature& s : kSignatures) {
    if (bytes.size() >= s.offset && bytes.substr(s.offset, s.bytes.size()) == s.bytes)
      return {s.name, s.extension};
    if (s.bytes[0] == '<' && std::string_view(start).substr(0, s.bytes.size()) == s.bytes)
      return {s.name, s.extension};
  }
  if (text.substr(0, 3) == "ply" && text.size() > 3 && (text[3] == '\n' || text[3] == '\r'))
    return {"a PLY mesh", ".ply"};
  const std::string word(Text(start).token());
  if (start.substr(0, 1) == "{")
    return text.find("\"asset\"") != text.npos ? FileKind{"a glTF file in text", ".gltf"}
                                               : FileKind{"a JSON file", ""};
  if (word == "solid" && lowerCase(text.substr(0, 4096)).find("facet") != std::string::npos)
    return {"an STL mesh", ".stl"};
  if (word == "off" || word == "coff" || word == "noff" || word == "stoff" || word == "cnoff")
    return {"an OFF mesh", ".off"};
  if (isWholeStl(bytes)) return {"an STL mesh", ".stl"};
  if (looksLikeObj(text)) return {"an OBJ mesh", ".obj"};
  return {};
}

}  // namespace slicemorph

#include "io/mesh/ply_header.h"

#include "io/mesh/mesh_text.h"

namespace slicemorph {
namespace {

/// The type of that name; of size 0 where there is none.
PlyType typeOf(std::string_view name) {
  if (name == "char" || name == "int8") return {1, false, true};
  if (name == "uchar" || name == "uint8") return {1, false, false};
  if (name == "short" || name == "int16") return {2, false, true};
  if (name == "ushort" || name == "uint16") return {2, false, false};
  if (name == "int" || name == "int32") return {4, false, true};
  if (name == "uint" || name == "uint32") return {4, false, false};
  if (name == "float" || name == "float32") return {4, true, true};
  if (name == "double" || name == "float64") return {8, true, true};
  return {};
}

/// `tokens`: what follows the word `property`.
PlyProperty readProperty(const std::string& path, std::string_view line, Text tokens) {
  PlyProperty property;
  const std::string_view first = tokens.token();
  const bool list = first == "list";
  if (list) property.count = typeOf(tokens.token());
  property.type = typeOf(list ? tokens.token() : first);
  property.name = tokens.token();
  if (property.type.size == 0 || property.isList() != list)
    refuse(path, "is damaged: its header has the line '" + std::string(line.substr(0, 60)) + "'");
  return property;
}

}  // namespace

PlyHeader readPlyHeader(const std::string& path, std::string_view bytes) {
  if (bytes.substr(0, 3) != "ply" || (bytes.size() > 3 && !isSpace(bytes[3])))
    refuse(path, "is no PLY file: it does not begin with 'ply'");
  PlyHeader header;
  std::string format;
  // After a header whose lines end with CR, a body may begin with the byte of LF.
  const bool loneCr = bytes.size() > 4 && bytes[3] == '\r' && bytes[4] != '\n';
  Text text(bytes);
  while (!text.done()) {
    const std::string_view line = text.line();
    Text tokens(line);
    const std::string_view kind = tokens.token();
    if (kind == "format") format = tokens.token();
    if (kind == "element") {
      const std::string name(tokens.token());
      for (const PlyElement& element : header.elements)
        if (element.name == name) refuse(path, "is damaged: its header has the element '" + name + "' twice");
      header.elements.push_back({name, parseCount(path, tokens.token(), name.c_str(), bytes.size()), {}});
    }
    if (kind == "property" && !header.elements.empty())
      header.elements.back().properties.push_back(readProperty(path, line, tokens));
    if (kind != "end_header") continue;
    header.size = bytes.size() - text.rest().size();
    if (loneCr) header.size = size_t(line.data() - bytes.data()) + line.size() + 1;
    header.text = format == "ascii", header.bigEndian = format == "binary_big_endian";
    if (!header.text && !header.bigEndian && format != "binary_little_endian")
      refuse(path, "is damaged: its header gives the format '" + format + "'");
    return header;
  }
  refuseTruncated(path, "its header has no end");
}

}  // namespace slicemorph

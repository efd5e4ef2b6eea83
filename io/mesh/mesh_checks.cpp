#include "io/mesh/mesh_checks.h"

#include "io/mesh/mesh_text.h"
#include "io/mesh/ply_header.h"
#include "io/paths.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string_view>
#include <vector>

namespace slicemorph {
namespace {

/// The importer holds some ten times a file's size.
constexpr std::uint64_t kLargestFile = std::uint64_t(2) << 30;

std::string readWhole(const std::string& path) {
  const std::uint64_t size = sizeOfInput(path);
  if (size > kLargestFile) throw IoError(path + " is larger than 2 GiB, the most that is read of a mesh");
  std::string bytes(size, '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(bytes.data(), std::streamsize(size))) throw IoError(path + " cannot be read");
  return bytes;
}

// ---------------------------------------------------------------- OBJ

class ObjScan {
 public:
  ObjScan(const std::string& path, std::string_view bytes) : path_(path), text_(bytes) {
    counts_.endsInLine = bytes.back() != '\n';
  }

  MeshCounts run() {
    while (!text_.done()) {
      std::string_view line = text_.line();
      std::string joined;
      while (!text_.done() && endsInBackslash(line)) {
        joined = std::string(line.substr(0, line.find_last_of('\\'))) + " " + std::string(text_.line());
        line = joined;
      }
      Text tokens(line);
      const std::string_view kind = tokens.token();
      if (kind == "v") vertex(tokens);
      if (kind == "f") face(tokens);
      if (kind == "mtllib") counts_.materialFiles.emplace_back(trimmed(tokens.rest()));
      if (kind == "usemtl") usesMaterials_ = true;
    }
    // The importer gives faces without a material the file's last one.
    if (!usesMaterials_) counts_.materialFiles.clear();
    if (counts_.points == 0) refuse(path_, "holds no vertices: it is no OBJ mesh, or cut short");
    if (counts_.faces == 0) {
      refuse(path_, "holds " + std::to_string(counts_.points) +
                        " vertices but no faces: it is cut short, or no surface");
    }
    if (highest_ > counts_.points) {
      refuse(path_, "line " + std::to_string(highestLine_) + ": a face refers to vertex " +
                        std::to_string(highest_) + ", the file has " + std::to_string(counts_.points));
    }
    if (colored_ > 0 && colored_ < counts_.points) {
      refuse(path_, "gives colours to " + std::to_string(colored_) + " of its " +
                        std::to_string(counts_.points) + " vertices; give them to all or to none");
    }
    used_.resize(counts_.points + 1, false);
    counts_.unusedPoints = size_t(std::count(used_.begin() + 1, used_.end(), false));
    return counts_;
  }

 private:
  static bool endsInBackslash(std::string_view line) {
    while (!line.empty() && isSpace(line.back())) line.remove_suffix(1);
    return !line.empty() && line.back() == '\\';
  }

  std::string where() const { return "line " + std::to_string(text_.lineNumber()); }

  [[noreturn]] void incomplete(const std::string& what) const {
    if (text_.done() && counts_.endsInLine) refuseTruncated(path_, "the last line, " + what);
    refuse(path_, "is damaged: " + where() + ", " + what);
  }

  void vertex(Text& tokens) {
    ++counts_.points;
    const auto name = [&] { return "vertex " + std::to_string(counts_.points); };
    int numbers = 0;
    double value = 0;
    for (std::string_view token = tokens.token(); parse(token, value); token = tokens.token(), ++numbers) {
      if (!std::isfinite(value))
        refuse(path_, where() + ": " + name() + " is not finite (" + std::string(token) + ")");
    }
    if (numbers < 3) incomplete(name() + ", has no three numbers");
    if (numbers == 5 || numbers > 6) {
      refuse(path_, where() + ": " + name() + " has " + std::to_string(numbers) +
                        " numbers; 3 are its place, 4 a place and a weight, 6 a place and a colour");
    }
    colored_ += numbers == 6;
  }

  void face(Text& tokens) {
    ++counts_.faces;
    size_t corners = 0;
    for (std::string_view token = tokens.token(); !token.empty(); token = tokens.token()) {
      if (token.front() == '#') break;
      std::int64_t index = 0;
      if (!parse(token, index))
        incomplete("a face, has '" + std::string(token.substr(0, 20)) + "' for a corner");
      if (index < 0) index += std::int64_t(counts_.points) + 1;
      if (index < 1) refuse(path_, where() + ": a face refers to a vertex that does not exist");
      if (std::uint64_t(index) > highest_) {
        highest_ = std::uint64_t(index);
        highestLine_ = text_.lineNumber();
      }
      markUsed(std::uint64_t(index));
      ++corners;
    }
    if (corners < 3) incomplete("a face, has " + std::to_string(corners) + " corners");
  }

  void markUsed(std::uint64_t index) {
    if (index > kLargestFile) return;  // refused at the end: no file has so many vertices
    if (index >= used_.size()) used_.resize(std::max<size_t>(index + 1, counts_.points + 1), false);
    used_[index] = true;
  }

  const std::string& path_;
  Text text_;
  MeshCounts counts_;
  std::vector<bool> used_;
  size_t colored_ = 0;
  bool usesMaterials_ = false;
  std::uint64_t highest_ = 0;
  size_t highestLine_ = 0;
};

// ---------------------------------------------------------------- PLY

std::uint64_t plyListLength(std::string_view bytes, bool bigEndian) {
  std::uint64_t value = 0;
  for (size_t i = 0; i < bytes.size(); ++i) {
    value = value << 8 | std::uint8_t(bytes[bigEndian ? i : bytes.size() - 1 - i]);
  }
  return value;
}

/// False where the body ends inside this element; `at`: where it begins, then where the next one does.
bool skipBinary(std::string_view bytes, const PlyElement& element, bool bigEndian, std::uint64_t& at) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      std::uint64_t items = 1;
      if (property.isList()) {
        if (at + std::uint64_t(property.count.size) > bytes.size()) return false;
        items = plyListLength(bytes.substr(at, size_t(property.count.size)), bigEndian);
        at += std::uint64_t(property.count.size);
        if (items > bytes.size()) return false;
      }
      at += items * std::uint64_t(property.type.size);
      if (at > bytes.size()) return false;
    }
  }
  return true;
}

bool skipText(Text& text, const PlyElement& element) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      std::uint64_t items = 1;
      if (property.isList() && !parse(text.token(), items)) return false;
      for (std::uint64_t k = 0; k < items; ++k) {
        if (text.token().empty()) return false;
      }
    }
  }
  return true;
}

MeshCounts checkPly(const std::string& path, std::string_view bytes) {
  const PlyHeader header = readPlyHeader(path, bytes);
  MeshCounts counts;
  Text body(bytes.substr(header.size));
  std::uint64_t at = header.size;
  for (const PlyElement& element : header.elements) {
    const bool whole =
        header.text ? skipText(body, element) : skipBinary(bytes, element, header.bigEndian, at);
    if (!whole) {
      refuseTruncated(path, "the header says " + std::to_string(element.count) + " elements '" +
                                element.name + "', the file ends before the last of them");
    }
    if (element.name == "vertex") counts.points = element.count;
    if (element.name == "face") counts.faces = element.count;
  }
  return counts;
}

// ---------------------------------------------------------------- STL, OFF, GLB

std::uint32_t littleEndian32(std::string_view bytes, size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

MeshCounts checkStlText(const std::string& path, std::string_view bytes) {
  MeshCounts counts;
  size_t ended = 0, solids = 0, endedSolids = 0;
  Text text(bytes);
  while (!text.done()) {
    Text tokens(text.line());
    const std::string_view kind = tokens.token();
    counts.faces += kind == "facet";
    counts.points += kind == "vertex";
    ended += kind == "endfacet";
    solids += kind == "solid";
    endedSolids += kind == "endsolid";
  }
  if (counts.faces == 0) refuse(path, "holds no facets: it is no STL mesh, or cut short");
  if (counts.faces != ended || solids != endedSolids || counts.points != 3 * counts.faces) {
    refuseTruncated(path, std::to_string(counts.faces) + " facets begin and " + std::to_string(ended) +
                              " end, " + std::to_string(solids) + " solids begin and " +
                              std::to_string(endedSolids) + " end");
  }
  return counts;
}

MeshCounts checkStl(const std::string& path, std::string_view bytes) {
  // Binary headers may begin with 'solid' too: the size decides.
  const bool binarySized =
      bytes.size() >= 84 && bytes.size() == 84 + 50 * std::uint64_t(littleEndian32(bytes, 80));
  const bool text = bytes.substr(0, 5) == "solid" && bytes.find('\0') == std::string_view::npos;
  if (text && !binarySized) return checkStlText(path, bytes);
  if (bytes.size() < 84) refuseTruncated(path, "a binary STL begins with 84 bytes");
  const std::uint64_t count = littleEndian32(bytes, 80);
  if (bytes.size() < 84 + 50 * count) {
    refuseTruncated(path, "the header says " + std::to_string(count) + " triangles, which take " +
                              std::to_string(84 + 50 * count) + " bytes; the file has " +
                              std::to_string(bytes.size()));
  }
  if (!binarySized) {
    refuse(path, "is damaged: " + std::to_string(count) + " triangles take " +
                     std::to_string(84 + 50 * count) + " bytes, the file has " +
                     std::to_string(bytes.size()));
  }
  return {size_t(count) * 3, size_t(count), 0, false};
}

/// The lines of an OFF file that hold something.
class OffLines {
 public:
  explicit OffLines(std::string_view bytes) : text_(bytes) {}
  std::string_view next() {
    while (!text_.done()) {
      std::string_view line = text_.line();
      line = line.substr(0, line.find('#'));
      if (!Text(line).token().empty()) return line;
    }
    return {};
  }

 private:
  Text text_;
};

size_t tokenCount(std::string_view line) {
  Text tokens(line);
  size_t count = 0;
  while (!tokens.token().empty()) ++count;
  return count;
}

MeshCounts checkOff(const std::string& path, std::string_view bytes) {
  OffLines lines(bytes);
  std::string_view line = lines.next();
  Text first(line);
  if (first.token().find("OFF") == std::string_view::npos)
    refuse(path, "is no OFF file: it does not begin with 'OFF'");
  Text counts = tokenCount(line) > 1 ? first : Text(lines.next());
  MeshCounts result;
  result.points = parseCount(path, counts.token(), "vertices", bytes.size());
  result.faces = parseCount(path, counts.token(), "faces", bytes.size());
  for (size_t i = 0; i < result.points + result.faces; ++i) {
    line = lines.next();
    size_t needed = 3;
    if (i >= result.points) {
      std::uint64_t corners = 0;
      if (!parse(Text(line).token(), corners)) corners = 2;
      needed = size_t(std::min<std::uint64_t>(corners, bytes.size())) + 1;
    }
    if (line.empty() || tokenCount(line) < needed) {
      refuseTruncated(path, "the header says " + std::to_string(result.points) + " vertices and " +
                                std::to_string(result.faces) + " faces, the file ends or breaks off at " +
                                (i < result.points ? "vertex " + std::to_string(i + 1)
                                                   : "face " + std::to_string(i - result.points + 1)));
    }
  }
  return result;
}

/// The importer leaves out colours that are not one for each point, without a word.
void checkGlbColors(const std::string& path, std::string_view text) {
  const nlohmann::json gltf = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto countOf = [&](const nlohmann::json& accessor) {
    return gltf.at("accessors").at(accessor.get<size_t>()).at("count").get<size_t>();
  };
  try {
    for (const auto& mesh : gltf.at("meshes")) {
      for (const auto& primitive : mesh.at("primitives")) {
        const auto& attributes = primitive.at("attributes");
        if (!attributes.contains("COLOR_0")) continue;
        const size_t colors = countOf(attributes.at("COLOR_0")), points = countOf(attributes.at("POSITION"));
        if (colors == points) continue;
        refuse(path, "is damaged: a mesh of " + std::to_string(points) + " points has " +
                         std::to_string(colors) + " colours");
      }
    }
  } catch (const nlohmann::json::exception&) {  // the importer says what is wrong
  }
}

MeshCounts checkGlb(const std::string& path, std::string_view bytes) {
  if (bytes.size() < 12 || bytes.substr(0, 4) != "glTF") refuse(path, "is no binary glTF file");
  const std::uint64_t size = littleEndian32(bytes, 8);
  if (size > bytes.size()) {
    refuseTruncated(path, "the header says " + std::to_string(size) + " bytes, the file has " +
                              std::to_string(bytes.size()));
  }
  for (std::uint64_t at = 12; at + 8 <= size; at += 8 + std::uint64_t(littleEndian32(bytes, at))) {
    const std::uint32_t length = littleEndian32(bytes, at);
    if (at + 8 + length > size) refuse(path, "is damaged: a chunk reaches beyond the end");
    if (bytes.substr(at + 4, 4) == "JSON") checkGlbColors(path, bytes.substr(at + 8, length));
  }
  return {};
}

}  // namespace

MeshCounts checkMeshFile(const std::string& path) {
  const std::string bytes = readWhole(path), extension = extensionOf(path);
  if (extension == ".obj") return ObjScan(path, bytes).run();
  if (extension == ".ply") return checkPly(path, bytes);
  if (extension == ".stl") return checkStl(path, bytes);
  if (extension == ".off") return checkOff(path, bytes);
  return checkGlb(path, bytes);
}

}  // namespace slicemorph

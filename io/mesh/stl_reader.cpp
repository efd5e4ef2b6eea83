#include "io/mesh/mesh_reader.h"
#include "io/mesh/mesh_text.h"
#include "slicemorph/io/nothing.h"

#include <algorithm>
#include <cstring>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "binary STL is read as it lies in memory");

/// Bytes before the triangles of a binary STL, and of a triangle: a normal, three points and an attribute.
constexpr size_t kStlHeader = 84, kStlTriangle = 50;

/// A triangle whose corners are the next three points. STL has no shared points.
void addStlTriangle(PolygonMesh& mesh) {
  for (int i = 0; i < 3; ++i) mesh.corners.push_back(std::uint32_t(mesh.corners.size()));
  mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
}

void addStlPoint(const std::string& path, PolygonMesh& mesh, const Vec3s& point) {
  mesh.points.push_back(point);
  if (!isFinite(point)) refuseNotFinite(path, "point " + std::to_string(mesh.points.size()), point);
}

/// Reads the words of text STL in any case and on any lines.
class StlText {
 public:
  StlText(const std::string& path, std::string_view bytes) : path_(path), text_(bytes) {}

  PolygonMesh read() {
    for (std::string word = next(); !word.empty(); word = next()) {
      if (word == "solid" || word == "endsolid") {
        ++(word == "solid" ? solids_ : endedSolids_);
        passName();
      }
      if (word == "facet") beginFacet();
      if (word == "vertex") vertex();
      if (word == "endfacet") endFacet();
    }
    if (facets_ == 0 && solids_ > 0 && solids_ == endedSolids_)
      throw NothingError(path_, "holds no facets: it is empty");
    if (facets_ == 0) refuse(path_, "holds no facets: it is no STL mesh, or cut short");
    // A solid may have no first line, but each that begins must end.
    if (facets_ != ended_ || solids_ > endedSolids_ || endedSolids_ > std::max<size_t>(solids_, 1))
      refuseCut();
    return std::move(mesh_);
  }

 private:
  /// The next word in lower case; "end facet" counts as "endfacet".
  std::string next() {
    std::string word = lowerCase(text_.token());
    if (word == "end") word += lowerCase(text_.token());
    return word;
  }

  /// A name, which may be of several words, goes to the end of its line, or to a facet on the same line.
  void passName() {
    Text rest = text_;
    const std::string line = lowerCase(rest.line());
    const size_t facet = line.find("facet normal");
    Text after(text_.rest().substr(facet == std::string::npos ? line.size() : facet));
    text_ = after;
  }

  [[noreturn]] void refuseCut() const {
    refuseTruncated(path_, std::to_string(facets_) + " facets begin and " + std::to_string(ended_) +
                               " end, " + std::to_string(solids_) + " solids begin and " +
                               std::to_string(endedSolids_) + " end");
  }

  void beginFacet() {
    if (facets_ != ended_) refuseCut();
    ++facets_;
  }

  void endFacet() {
    ++ended_;
    if (facets_ != ended_) refuseCut();
    if (mesh_.points.size() != 3 * facets_)
      refuse(path_, "is damaged: facet " + std::to_string(facets_) + " has " +
                        std::to_string(mesh_.points.size() + 3 - 3 * facets_) + " vertices, not three");
    addStlTriangle(mesh_);
  }

  void vertex() {
    Vec3s point;
    for (int d = 0; d < 3; ++d) {
      const std::string_view token = text_.token();
      const std::optional<double> number = wholeNumber(token);
      if (!number && text_.done()) refuseCut();
      if (!number)
        refuse(path_, "is damaged: vertex " + std::to_string(mesh_.points.size() + 1) + " has '" +
                          std::string(token.substr(0, 20)) + "' for a number");
      point[d] = float(*number);
    }
    if (facets_ == ended_) refuseCut();
    addStlPoint(path_, mesh_, point);
  }

  const std::string& path_;
  Text text_;
  PolygonMesh mesh_;
  size_t facets_ = 0, ended_ = 0, solids_ = 0, endedSolids_ = 0;
};

/// Whether it is text: headers of binary files may begin with "solid" too, so before the first facet there must
/// be no zero byte.
bool isStlText(std::string_view bytes) {
  Text text(bytes.substr(0, bytes.find('\0')));
  const std::string first = lowerCase(text.token());
  if (first != "solid" && first != "facet") return false;
  const std::string rest = lowerCase(text.rest().substr(0, 4096));
  return bytes.find('\0') == std::string_view::npos || first == "facet" ||
         rest.find("facet") != std::string::npos;
}

StoredMesh readStlBytes(const std::string& path, std::string_view bytes) {
  if (bytes.size() < kStlHeader) refuseTruncated(path, "a binary STL begins with 84 bytes");
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kStlHeader - 4, sizeof count);
  const std::uint64_t size = kStlHeader + kStlTriangle * std::uint64_t(count);
  if (bytes.size() < size)
    refuseTruncated(path, "the header says " + std::to_string(count) + " triangles, which take " +
                              std::to_string(size) + " bytes; the file has " + std::to_string(bytes.size()));
  if (count == 0 && bytes.size() == size) throw NothingError(path, "holds no triangles: it is empty");
  if (count == 0) refuse(path, "holds no triangles: it is no STL mesh, or damaged");
  StoredMesh stored;
  for (size_t t = 0; t < count; ++t) {
    float numbers[12];
    std::memcpy(numbers, bytes.data() + kStlHeader + t * kStlTriangle, sizeof numbers);
    for (int i = 1; i < 4; ++i)
      addStlPoint(path, stored.mesh, {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]});
    addStlTriangle(stored.mesh);
  }
  if (bytes.size() > size)
    stored.notes.emplace_back("mesh.trailing-bytes", Severity::kWarning, "",
                              "its header says " + std::to_string(count) + " triangles; the " +
                                  std::to_string(bytes.size() - size) +
                                  " bytes after the last of them are not read");
  return stored;
}

}  // namespace

/// Reads text STL in any case, with any line ends and several solids, and binary STL, also where its header
/// begins with "solid" or bytes follow the last triangle.
StoredMesh readStl(const std::string& path, std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kStlHeader) std::memcpy(&count, bytes.data() + kStlHeader - 4, sizeof count);
  // The size decides where it fits: text cannot have it but by chance.
  const bool fits = bytes.size() == kStlHeader + kStlTriangle * std::uint64_t(count);
  std::string memory;
  const std::string_view text = plainText(bytes, memory);
  StoredMesh stored;
  if (!fits && isStlText(text))
    stored.mesh = StlText(path, text).read();
  else
    stored = readStlBytes(path, bytes);
  stored.points = stored.mesh.points.size(), stored.faces = stored.mesh.faceCount();
  stored.mesh.importCopies = stored.mesh.points.size();  // the format has no shared points
  return stored;
}

}  // namespace slicemorph

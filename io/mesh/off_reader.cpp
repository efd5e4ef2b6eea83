#include "io/mesh/mesh_reader.h"
#include "io/mesh/mesh_text.h"
#include "io/mesh/off_header.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

/// Numbers of an OFF file before they are looked at: those of a vertex's or a face's line.
using OffNumbers = std::vector<double>;

struct OffCounts {
  std::uint64_t points = 0, faces = 0;
};

/// Lines of an OFF file without comments; empty ones are skipped.
class OffLines {
 public:
  explicit OffLines(std::string_view bytes) : text_(bytes) {}
  /// Empty at the end.
  std::string_view next() {
    while (!text_.done()) {
      const std::string_view line = trimmed(cut(text_.line()));
      if (!line.empty()) return line;
    }
    return {};
  }

 private:
  static std::string_view cut(std::string_view line) { return line.substr(0, line.find('#')); }
  Text text_;
};

/// Where a colour's numbers are and what they mean is settled once all are known.
struct OffColors {
  std::vector<Vec3s> values;
  std::vector<bool> there;
  size_t found = 0;
  double most = 0;

  void add(const double* rgb) {
    values.push_back(rgb ? Vec3s(float(rgb[0]), float(rgb[1]), float(rgb[2])) : Vec3s(1.f));
    there.push_back(rgb != nullptr);
    found += rgb != nullptr;
    for (int i = 0; rgb && i < 3; ++i) most = std::max(most, rgb[i]);
  }
  /// Numbers above 1 are bytes.
  Vec3s at(size_t i) const { return there[i] && most > 1 ? values[i] / 255.f : values[i]; }
};

class OffReader {
 public:
  OffReader(const std::string& path, const OffHeader& header) : path_(path), header_(header) {}

  StoredMesh readText() {
    OffLines lines(header_.rest);
    const OffCounts counts = countsOf(lines);
    if (!readLines(lines, counts)) {
      points_ = faces_ = {};
      OffLines again(header_.rest);
      countsOf(again);
      readStream(again, counts);
    }
    return meshOf();
  }

  /// Layouts differ in the order of bytes and in whether faces end with a number of colour values: the one that
  /// uses up the file is taken.
  StoredMesh readBytes() {
    bool whole = false;
    for (const bool big : {true, false})
      for (const bool colors : {true, false})
        if (!whole) whole = readLayout(big, colors);
    if (!whole)
      refuse(path_,
             "is truncated or damaged: neither as big nor as little endian do its counts and faces fit its " +
                 std::to_string(header_.rest.size()) + " bytes of data");
    return meshOf();
  }

 private:
  /// Numbers of vertices, faces and edges, on one line or on several; that of edges may be missing.
  OffCounts countsOf(OffLines& lines) {
    OffCounts counts;
    std::string_view line = lines.next();
    Text words(line);
    const size_t size = header_.rest.size();
    counts.points = parseCount(path_, words.token(), "vertices", size);
    words = Text(trimmed(words.rest()));
    const bool apart = words.done();
    if (apart) words = Text(lines.next());
    counts.faces = parseCount(path_, words.token(), "faces", size);
    const std::string_view edges = words.token();
    if (apart && edges.empty()) {  // a third line of one number is that of edges
      OffLines ahead = lines;
      Text third(ahead.next());
      if (!third.token().empty() && third.token().empty()) lines = ahead;
    }
    std::string_view more = trimmed(words.rest());
    if (!more.empty()) first_ = more;
    return counts;
  }

  static std::optional<OffNumbers> numbersOf(std::string_view line) {
    OffNumbers numbers;
    Text tokens(line);
    for (auto token = tokens.token(); !token.empty(); token = tokens.token()) {
      const std::optional<double> number = wholeNumber(token);
      if (!number) return std::nullopt;
      numbers.push_back(*number);
    }
    return numbers;
  }

  /// False where not every vertex and every face has a line of its own. Lines after the last are only told.
  bool readLines(OffLines& lines, const OffCounts& counts) {
    if (!first_.empty()) return false;
    for (std::uint64_t i = 0; i < counts.points + counts.faces; ++i) {
      const bool point = i < counts.points;
      const std::optional<OffNumbers> numbers = numbersOf(lines.next());
      const size_t least = point ? size_t(header_.placeNumbers()) : 1;
      if (!numbers || numbers->size() < least) return false;
      if (!point && !(numbers->size() > (*numbers)[0])) return false;
      (point ? points_ : faces_).push_back(*numbers);
    }
    more_ = !lines.next().empty();
    return true;
  }

  /// Vertices and faces one after the other, anyhow on lines; faces have no colours then.
  void readStream(OffLines& lines, const OffCounts& counts) {
    Text words(first_.empty() ? lines.next() : first_);
    const auto next = [&](std::uint64_t i) {
      std::string_view token = words.token();
      while (token.empty()) {
        const std::string_view line = lines.next();
        if (line.empty()) refuseEnd(counts, i);
        words = Text(line);
        token = words.token();
      }
      const std::optional<double> number = wholeNumber(token);
      if (!number)
        refuse(path_, "is damaged: '" + std::string(token.substr(0, 20)) + "' stands for a number");
      return *number;
    };
    const int perPoint =
        header_.placeNumbers() + 3 * header_.normals + 4 * header_.colors + 2 * header_.texture;
    for (std::uint64_t i = 0; i < counts.points + counts.faces; ++i) {
      const bool point = i < counts.points;
      OffNumbers numbers;
      if (!point) numbers.push_back(next(i));
      const double more = point ? perPoint : numbers[0];
      for (double k = 0; k < more; ++k) numbers.push_back(next(i));
      (point ? points_ : faces_).push_back(std::move(numbers));
    }
    if (!words.token().empty() || !lines.next().empty())
      refuse(path_, "is damaged: more numbers follow its " + std::to_string(counts.points) +
                        " vertices and " + std::to_string(counts.faces) + " faces");
  }

  [[noreturn]] void refuseEnd(const OffCounts& counts, std::uint64_t i) const {
    refuseTruncated(path_, "the header says " + std::to_string(counts.points) + " vertices and " +
                               std::to_string(counts.faces) + " faces, the file ends or breaks off at " +
                               (i < counts.points ? "vertex " + std::to_string(i + 1)
                                                  : "face " + std::to_string(i - counts.points + 1)));
  }

  /// False where the bytes end before the last face or after it, or faces refer to points that are not there.
  bool readLayout(bool bigEndian, bool faceColors) {
    points_ = faces_ = {};
    const std::string_view bytes = header_.rest;
    size_t at = 0;
    const auto next = [&](auto number) {
      char raw[4] = {};
      if (bytes.size() - at >= 4) std::memcpy(raw, bytes.data() + at, 4);
      if (bigEndian) std::reverse(raw, raw + 4);
      std::memcpy(&number, raw, 4);
      at += 4;
      return number;
    };
    const auto left = [&] { return (bytes.size() - at) / 4; };
    if (bytes.size() < 12) return false;
    const std::uint32_t points = next(std::uint32_t()), faces = next(std::uint32_t());
    next(std::uint32_t());
    const size_t perPoint =
        size_t(header_.placeNumbers()) + 3 * header_.normals + 4 * header_.colors + 2 * header_.texture;
    if (points > left() / perPoint) return false;
    for (std::uint32_t i = 0; i < points; ++i) {
      points_.emplace_back(perPoint);
      for (double& number : points_.back()) number = next(float());
    }
    for (std::uint32_t f = 0; f < faces; ++f) {
      if (left() == 0) return false;
      const std::uint32_t corners = next(std::uint32_t());
      if (corners > left()) return false;
      faces_.push_back({double(corners)});
      for (std::uint32_t k = 0; k < corners; ++k) {
        faces_.back().push_back(next(std::uint32_t()));
        if (!(faces_.back().back() < points)) return false;
      }
      if (!faceColors) continue;
      if (left() == 0) return false;
      const std::uint32_t colors = next(std::uint32_t());
      if (colors > 4 || colors > left()) return false;
      for (std::uint32_t k = 0; k < colors; ++k) faces_.back().push_back(next(float()));
    }
    return at == bytes.size();
  }

  /// Colours of points are where the header says so; plain files may have three or four numbers more as well.
  StoredMesh meshOf() {
    StoredMesh stored;
    stored.points = points_.size(), stored.faces = faces_.size();
    PolygonMesh& mesh = stored.mesh;
    OffColors ofPoints, ofFaces;
    const size_t place = size_t(header_.placeNumbers()), before = place + 3 * header_.normals;
    const bool plain = !header_.normals && !header_.texture && !header_.colors;
    for (const OffNumbers& n : points_) {
      stored.addPoint(Vec3d(n[0], n[1], n[2]) / (header_.weighted ? n[3] : 1.0));
      if (!isFinite(mesh.points.back()))
        refuseNotFinite(path_, "point " + std::to_string(mesh.points.size()), mesh.points.back());
      const size_t rest = n.size() - std::min(n.size(), before + 2 * header_.texture);
      const bool colored = header_.colors ? rest >= 3 : plain && (rest == 3 || rest == 4);
      ofPoints.add(colored ? &n[before] : nullptr);
    }
    std::vector<size_t> faceOf;
    for (const OffNumbers& n : faces_) {
      if (!(n[0] >= 3)) ++stored.skipped;
      if (!(n[0] >= 3)) continue;
      const size_t corners = size_t(n[0]);
      ofFaces.add(n.size() - corners - 1 >= 3 ? &n[corners + 1] : nullptr);
      for (size_t k = 1; k <= corners; ++k) addOffCorner(mesh, n[k], points_.size());
      mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
    }
    setColors(stored, ofPoints, ofFaces);
    stored.endsInLine = !header_.binary && !header_.rest.empty() && header_.rest.back() != '\n' &&
                        header_.rest.back() != '\r';
    if (more_)
      stored.notes.emplace_back("mesh.trailing-bytes", Severity::kWarning, "",
                                "lines follow the " + std::to_string(faces_.size()) +
                                    " faces that its header counts: they are not read");
    return stored;
  }

  void addOffCorner(PolygonMesh& mesh, double corner, size_t points) const {
    if (!(corner >= 0 && corner < double(points) && corner == std::floor(corner))) {
      std::ostringstream why;
      why << "face " << mesh.faceCount() + 1 << " refers to vertex " << corner << ", the file has " << points
          << ", counted from 0";
      refuse(path_, why.str());
    }
    mesh.corners.push_back(std::uint32_t(corner));
  }

  /// Colours of all points win over those of faces; faces without one are white.
  void setColors(StoredMesh& stored, const OffColors& ofPoints, const OffColors& ofFaces) const {
    PolygonMesh& mesh = stored.mesh;
    const bool points = ofPoints.found > 0 && ofPoints.found == points_.size();
    if (!points && ofFaces.found == 0) return;
    stored.colorsOf = points ? "points" : "faces";
    for (size_t f = 0; f < mesh.faceCount(); ++f)
      for (std::uint32_t k = mesh.faceStarts[f]; k < mesh.faceStarts[f + 1]; ++k) {
        mesh.colors.push_back(points ? ofPoints.at(mesh.corners[k]) : ofFaces.at(f));
        if (!isFinite(mesh.colors.back()))
          refuseNotFinite(path_,
                          points ? "the colour of point " + std::to_string(mesh.corners[k] + 1)
                                 : "the colour of face " + std::to_string(f + 1),
                          mesh.colors.back());
      }
  }

  const std::string& path_;
  const OffHeader& header_;
  std::string_view first_;  ///< numbers that follow the counts on their line
  std::vector<OffNumbers> points_, faces_;
  bool more_ = false;  ///< lines follow the last face
};

}  // namespace

/// Reads OFF as Geomview and others write it: text with comments, blank lines and numbers on any lines, and
/// binary of either byte order; normals, colours and texture coordinates of vertices where the header says so,
/// colours of faces. (Assimp reads no binary files and few headers.)
StoredMesh readOff(const std::string& path, std::string_view bytes) {
  std::string memory;
  const OffHeader header = readOffHeader(path, plainText(bytes, memory));
  OffReader reader(path, header);
  return header.binary ? reader.readBytes() : reader.readText();
}

}  // namespace slicemorph

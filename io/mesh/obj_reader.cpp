#include "io/mesh/mesh_reader.h"
#include "io/mesh/mesh_text.h"
#include "io/mesh/obj_materials.h"
#include "io/mesh/texture_set.h"
#include "io/whole_file.h"
#include "slicemorph/io/nothing.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

/// Reads the polygons of an OBJ file with the colours of points and materials. Refers to the bytes given.
class ObjReader {
 public:
  ObjReader(const std::string& path, std::string_view bytes) : path_(path), text_(bytes) {
    stored_.endsInLine = bytes.empty() || (bytes.back() != '\n' && bytes.back() != '\r');
  }

  StoredMesh read() {
    while (!text_.done()) {
      std::string_view line = text_.line();
      std::string joined;
      while (!text_.done() && endsInBackslash(line)) {
        joined = std::string(line.substr(0, line.find_last_of('\\'))) + " " + std::string(text_.line());
        line = joined;
      }
      readLine(line);
    }
    checkWhole();
    setColors();
    stored_.points = stored_.mesh.points.size(), stored_.faces = stored_.mesh.faceCount();
    return std::move(stored_);
  }

 private:
  /// Whether lines of OBJ files begin so, also of those that hold no surface.
  static bool isObjWord(const std::string& kind) {
    static const char* const kWords[] = {"v", "vt", "vn", "vp", "f",  "fo",     "l",
                                         "p", "o",  "g",  "s",  "mg", "mtllib", "usemtl"};
    return std::find(std::begin(kWords), std::end(kWords), kind) != std::end(kWords);
  }

  static bool endsInBackslash(std::string_view line) {
    line = trimmed(line);
    return !line.empty() && line.back() == '\\';
  }

  void readLine(std::string_view line) {
    Text tokens(line);
    const std::string kind = lowerCase(tokens.token());
    if (kind == "v") vertex(tokens);
    if (kind == "vt") texturePoint(tokens);
    if (kind == "f" || kind == "fo") face(tokens);
    if (kind == "l" || kind == "p") ++stored_.skipped;
    if (!kind.empty() && kind[0] != '#' && !isObjWord(kind)) foreign_ = true;
    if (kind == "mtllib") libraries_.emplace_back(trimmed(tokens.rest()));
    if (kind == "usemtl") material_ = materialNamed(std::string(trimmed(tokens.rest())));
  }

  std::string where() const { return "line " + std::to_string(text_.lineNumber()); }

  [[noreturn]] void incomplete(const std::string& what) const {
    if (text_.done() && stored_.endsInLine) refuseTruncated(path_, "the last line, " + what);
    refuse(path_, "is damaged: " + where() + ", " + what);
  }

  void vertex(Text& tokens) {
    const auto name = [&] { return "vertex " + std::to_string(stored_.mesh.points.size() + 1); };
    double numbers[6] = {};
    int count = 0;
    for (auto token = tokens.token(); !token.empty() && token.front() != '#'; token = tokens.token()) {
      const std::optional<double> number = wholeNumber(token);
      if (!number) incomplete(name() + ", has '" + std::string(token.substr(0, 20)) + "' for a number");
      if (!std::isfinite(*number))
        refuse(path_, where() + ": " + name() + " is not finite (" + std::string(token) + ")");
      if (count < 6) numbers[count] = *number;
      ++count;
    }
    if (count < 3) incomplete(name() + ", has no three numbers");
    if (count == 5 || count > 6)
      refuse(path_, where() + ": " + name() + " has " + std::to_string(count) +
                        " numbers; 3 are its place, 4 a place and a weight, 6 a place and a colour");
    if (count == 4 && numbers[3] == 0)
      refuse(path_, where() + ": " + name() + " has the weight 0: it is infinitely far away");
    const double weight = count == 4 ? numbers[3] : 1;
    const Vec3d point = Vec3d(numbers[0], numbers[1], numbers[2]) / weight;
    if (!isFinite(Vec3s(point))) refuseNotFinite(path_, where() + ": " + name(), Vec3s(point));
    stored_.addPoint(point);
    if (count == 6) pointColors_.emplace_back(numbers[3], numbers[4], numbers[5]);
  }

  void texturePoint(Text& tokens) {
    const double u = wholeNumber(tokens.token()).value_or(0), v = wholeNumber(tokens.token()).value_or(0);
    texturePoints_.emplace_back(u, v);
  }

  /// Index of a corner's texture coordinates, from 0; below 0: it has none.
  std::int64_t textureOfCorner(std::string_view corner) const {
    const size_t slash = corner.find('/');
    std::int64_t index = 0;
    if (slash == corner.npos || !parse(corner.substr(slash + 1), index)) return -1;
    return index < 0 ? index + std::int64_t(texturePoints_.size()) : index - 1;
  }

  /// Corners are `point`, `point/texture`, `point//normal` or `point/texture/normal`, from 1, or from the end
  /// where negative.
  void face(Text& tokens) {
    std::vector<std::uint32_t>& corners = stored_.mesh.corners;
    const size_t first = corners.size();
    for (auto token = tokens.token(); !token.empty() && token.front() != '#'; token = tokens.token()) {
      std::int64_t index = 0;
      if (!parse(token, index))
        incomplete("a face, has '" + std::string(token.substr(0, 20)) + "' for a corner");
      if (index < 0) index += std::int64_t(stored_.mesh.points.size()) + 1;
      if (index < 1) refuse(path_, where() + ": a face refers to a vertex that does not exist");
      if (std::uint64_t(index) > highest_) {
        highest_ = std::uint64_t(index);
        highestLine_ = text_.lineNumber();
      }
      corners.push_back(std::uint32_t(index - 1));
      textureOfCorner_.push_back(textureOfCorner(token));
    }
    if (corners.size() - first < 3)
      incomplete("a face, has " + std::to_string(corners.size() - first) + " corners");
    stored_.mesh.faceStarts.push_back(std::uint32_t(corners.size()));
    materialOfFace_.push_back(material_);
  }

  int materialNamed(const std::string& name) {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) return names_.push_back(name), int(names_.size()) - 1;
    return int(found - names_.begin());
  }

  void checkWhole() const {
    const size_t points = stored_.mesh.points.size();
    // Programs write a mesh without points as comments and names alone.
    if (points == 0 && stored_.mesh.faceCount() == 0 && !foreign_ && !stored_.endsInLine)
      throw NothingError(path_, "holds no vertices: it is empty");
    if (points == 0) refuse(path_, "holds no vertices: it is no OBJ mesh, or cut short");
    if (stored_.mesh.faceCount() == 0)
      refuse(path_,
             "holds " + std::to_string(points) + " vertices but no faces: it is cut short, or no surface");
    if (highest_ > points)
      refuse(path_, "line " + std::to_string(highestLine_) + ": a face refers to vertex " +
                        std::to_string(highest_) + ", the file has " + std::to_string(points));
    if (!pointColors_.empty() && pointColors_.size() < points)
      refuse(path_, "gives colours to " + std::to_string(pointColors_.size()) + " of its " +
                        std::to_string(points) + " vertices; give them to all or to none");
  }

  std::vector<ObjMaterial> materials() const {
    const ObjMaterials library = names_.empty() ? ObjMaterials() : readObjMaterials(path_, libraries_);
    std::vector<ObjMaterial> materials(names_.size());
    for (size_t m = 0; m < names_.size(); ++m)
      if (const auto found = library.find(names_[m]); found != library.end()) materials[m] = found->second;
    return materials;
  }

  /// Colours of corners: Kd times the texture, else the points' own, else Kd, else white; none where no face has any.
  void setColors() {
    const std::vector<ObjMaterial> materials = this->materials();
    PolygonMesh& mesh = stored_.mesh;
    if (!pointColors_.empty()) stored_.colorsOf = "points";
    TextureSet textures;
    for (size_t f = 0; f < mesh.faceCount(); ++f) {
      static const ObjMaterial kNothing;
      const ObjMaterial& own = materialOfFace_[f] < 0 ? kNothing : materials[size_t(materialOfFace_[f])];
      if (own.color && stored_.colorsOf.empty()) stored_.colorsOf = "materials";
      const int texture = textureOf(own.texture, f, textures);
      mesh.textureOfFace.push_back(texture);
      // Black under a texture, as some programs write it, would hide it.
      const bool hides = texture >= 0 && own.color == Vec3s(0.f);
      const Vec3s color = hides ? Vec3s(1.f) : own.color.value_or(Vec3s(1.f));
      for (std::uint32_t k = mesh.faceStarts[f]; k < mesh.faceStarts[f + 1]; ++k)
        mesh.colors.push_back(texture >= 0 || pointColors_.empty() ? color : pointColors_[mesh.corners[k]]);
    }
    textures.finish(stored_);
    if (stored_.colorsOf.empty()) mesh.colors.clear();
    if (bare_ > 0)
      stored_.notes.emplace_back(
          "mesh.texture-coordinates-missing", Severity::kWarning, "",
          std::to_string(bare_) +
              " faces with a texture have no texture coordinates: they take their material's colour");
  }

  /// Index of a face's texture; -1: it has none. Adds the coordinates of its corners.
  int textureOf(const ObjTexture& texture, size_t face, TextureSet& textures) {
    PolygonMesh& mesh = stored_.mesh;
    const std::uint32_t first = mesh.faceStarts[face], last = mesh.faceStarts[face + 1];
    bool whole = !texture.file.empty();
    for (std::uint32_t k = first; k < last; ++k) {
      const std::int64_t i = textureOfCorner_[k];
      const bool there = i >= 0 && size_t(i) < texturePoints_.size();
      whole &= there;
      const openvdb::Vec2d uv =
          there ? texturePoints_[size_t(i)] * texture.scale + texture.offset : openvdb::Vec2d(0.0);
      mesh.uvs.emplace_back(float(uv[0]), float(1 - uv[1]));  // rows of pictures go down, v goes up
    }
    bare_ += !whole && !texture.file.empty();
    if (!whole) return -1;
    const std::string key = texture.file + (texture.sampling.u == TextureWrap::kClamp ? " -clamp" : "");
    return textures.indexOf(key,
                            [&] { return textureOfPicture(readWholeFile(texture.file), texture.sampling); });
  }

  const std::string& path_;
  Text text_;
  StoredMesh stored_;
  std::vector<Vec3s> pointColors_;
  std::vector<openvdb::Vec2d> texturePoints_;
  std::vector<std::int64_t> textureOfCorner_;   ///< index into texturePoints_; out of its range: none
  size_t bare_ = 0;                             ///< faces with a texture but without coordinates
  std::vector<std::string> names_, libraries_;  ///< of materials that are used, and of .mtl files
  std::vector<int> materialOfFace_;             ///< index into names_; -1: none
  bool foreign_ = false;                        ///< there are lines that no OBJ file has
  int material_ = -1;
  std::uint64_t highest_ = 0;
  size_t highestLine_ = 0;
};

}  // namespace

/// Reads OBJ as it is written: lines that end with CR, LF or both, continued lines, upper case, a byte order
/// mark, negative indices, corners with or without texture and normal. Curves, lines and points are passed
/// over. (Assimp refuses several of these, and says nothing where faces refer to points that are not there.)
StoredMesh readObj(const std::string& path, std::string_view bytes) {
  std::string memory;
  return ObjReader(path, plainText(bytes, memory)).read();
}

}  // namespace slicemorph

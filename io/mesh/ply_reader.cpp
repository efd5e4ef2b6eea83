#include "io/mesh/mesh_reader.h"
#include "io/mesh/mesh_text.h"
#include "io/mesh/ply_check.h"
#include "io/mesh/ply_header.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "binary PLY is read as it lies in memory");

/// Reads the numbers of a PLY file's body one after the other.
class PlyNumbers {
 public:
  PlyNumbers(const std::string& path, std::string_view bytes, const PlyHeader& header)
      : path_(path), header_(header), body_(bytes.substr(header.size)), text_(body_) {}

  double next(const PlyType& type) {
    if (header_.text) return nextOfText();
    char bytes[8];
    if (body_.size() - at_ < size_t(type.size)) refuseTruncated(path_, "it ends inside the data");
    std::memcpy(bytes, body_.data() + at_, size_t(type.size));
    at_ += size_t(type.size);
    if (header_.bigEndian) std::reverse(bytes, bytes + type.size);
    if (type.real) return type.size == 4 ? as<float>(bytes) : as<double>(bytes);
    if (type.size == 1) return type.isSigned ? as<std::int8_t>(bytes) : as<std::uint8_t>(bytes);
    if (type.size == 2) return type.isSigned ? as<std::int16_t>(bytes) : as<std::uint16_t>(bytes);
    return type.isSigned ? as<std::int32_t>(bytes) : as<std::uint32_t>(bytes);
  }

 private:
  template <typename Number>
  static double as(const char* bytes) {
    Number number;
    std::memcpy(&number, bytes, sizeof number);
    return double(number);
  }

  double nextOfText() {
    const std::string_view token = text_.token();
    double value = 0;
    if (!parse(token, value))
      refuse(path_, "is damaged: '" + std::string(token.substr(0, 20)) + "' stands for a number");
    return value;
  }

  const std::string& path_;
  const PlyHeader& header_;
  std::string_view body_;
  Text text_;
  size_t at_ = 0;
};

enum class PlyRole { kPosition, kColor, kCorners, kOther };

/// The meaning of a property for a mesh.
struct PlyPart {
  PlyRole role = PlyRole::kOther;
  int axis = 0;      ///< component of a position or colour
  double scale = 1;  ///< of colours: factor that brings their numbers to 0 to 1
};

PlyPart partOf(const PlyProperty& property) {
  static constexpr const char* kAxes[3] = {"x", "y", "z"};
  static constexpr const char* kChannels[3][3] = {
      {"red", "diffuse_red", "r"}, {"green", "diffuse_green", "g"}, {"blue", "diffuse_blue", "b"}};
  const std::string& name = property.name;
  if (property.isList())
    return {name == "vertex_indices" || name == "vertex_index" ? PlyRole::kCorners : PlyRole::kOther, 0};
  const PlyType& type = property.type;
  const double most = type.real ? 1 : std::ldexp(1.0, 8 * type.size - (type.isSigned ? 1 : 0)) - 1;
  for (int d = 0; d < 3; ++d) {
    if (name == kAxes[d]) return {PlyRole::kPosition, d};
    for (const char* channel : kChannels[d])
      if (name == channel) return {PlyRole::kColor, d, 1 / most};
  }
  return {};
}

class PlyReader {
 public:
  PlyReader(const std::string& path, std::string_view bytes, const PlyHeader& header)
      : path_(path), header_(header), numbers_(path, bytes, header_) {}

  StoredMesh read() {
    for (const PlyElement& element : header_.elements) readElement(element);
    checkCorners();
    PolygonMesh& mesh = stored_.mesh;
    if (!pointColors_.empty()) {
      mesh.colors.clear();
      for (std::uint32_t corner : mesh.corners) mesh.colors.push_back(pointColors_[corner]);
      stored_.colorsOf = "points";
    } else if (stored_.colorsOf.empty()) {
      mesh.colors.clear();
    }
    return std::move(stored_);
  }

 private:
  void readElement(const PlyElement& element) {
    std::vector<PlyPart> parts;
    for (const PlyProperty& property : element.properties) parts.push_back(partOf(property));
    const auto hasAll = [&](PlyRole role) {
      bool has[3] = {false, false, false};
      for (const PlyPart& part : parts) has[part.axis] |= part.role == role;
      return has[0] && has[1] && has[2];
    };
    const bool colored = hasAll(PlyRole::kColor), points = element.name == "vertex",
               faces = element.name == "face";
    if (points && !hasAll(PlyRole::kPosition)) refuse(path_, "is damaged: its vertices have no x, y and z");
    if (faces && colored && element.count > 0) stored_.colorsOf = "faces";
    for (std::uint64_t row = 0; row < element.count; ++row) {
      readRow(element, parts);
      if (points) stored_.addPoint(position_);
      if (points && colored) pointColors_.push_back(color_);
      if (points && !isFinite(stored_.mesh.points.back()))
        refuseNotFinite(path_, "point " + std::to_string(row + 1), stored_.mesh.points.back());
      if (colored && (points || faces) && !isFinite(color_))
        refuseNotFinite(path_,
                        (points ? "the colour of point " : "the colour of face ") + std::to_string(row + 1),
                        color_);
      if (faces) addPolygon(corners_, colored ? color_ : kWhite_);
      if (element.name == "tristrips") addStrips();
    }
  }

  void readRow(const PlyElement& element, const std::vector<PlyPart>& parts) {
    corners_.clear();
    for (size_t i = 0; i < parts.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      const PlyPart& part = parts[i];
      if (property.isList()) {
        // Counts are never negative, so they are read as unsigned even where their type is signed.
        const PlyType count{property.count.size, property.count.real, false};
        for (double items = std::floor(numbers_.next(count)); items > 0; --items) {
          const double item = numbers_.next(property.type);
          if (part.role == PlyRole::kCorners) corners_.push_back(item);
        }
        continue;
      }
      const double value = numbers_.next(property.type);
      if (part.role == PlyRole::kPosition) position_[part.axis] = value;
      if (part.role == PlyRole::kColor) color_[part.axis] = float(value * part.scale);
    }
  }

  void addPolygon(const std::vector<double>& corners, const Vec3s& color) {
    PolygonMesh& mesh = stored_.mesh;
    if (corners.size() < 3) {
      ++stored_.skipped;
      return;
    }
    for (double corner : corners) {
      if (!(corner >= 0 && corner < double(~std::uint32_t(0)))) refusePlyCorner(mesh.faceCount(), corner);
      mesh.corners.push_back(std::uint32_t(corner));
      mesh.colors.push_back(color);
    }
    mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
  }

  /// A negative index ends a strip; every second triangle of a strip is wound the other way round.
  void addStrips() {
    for (size_t i = 0, first = 0; i < corners_.size(); ++i) {
      if (corners_[i] < 0) first = i + 1;
      if (i < first + 2) continue;
      const bool turned = (i - first) % 2 == 1;
      addPolygon({corners_[i - 2], corners_[turned ? i : i - 1], corners_[turned ? i - 1 : i]}, kWhite_);
    }
  }

  [[noreturn]] void refusePlyCorner(size_t face, double corner) const {
    std::ostringstream why;
    why.precision(12);
    why << "face " << face + 1 << " refers to vertex " << corner << ", the file has "
        << stored_.mesh.points.size() << ", counted from 0";
    refuse(path_, why.str());
  }

  void checkCorners() const {
    const PolygonMesh& mesh = stored_.mesh;
    for (size_t f = 0; f < mesh.faceCount(); ++f)
      for (std::uint32_t k = mesh.faceStarts[f]; k < mesh.faceStarts[f + 1]; ++k)
        if (mesh.corners[k] >= mesh.points.size()) refusePlyCorner(f, mesh.corners[k]);
  }

  const Vec3s kWhite_{1.f, 1.f, 1.f};
  const std::string& path_;
  const PlyHeader& header_;
  PlyNumbers numbers_;
  StoredMesh stored_;
  std::vector<Vec3s> pointColors_;
  Vec3d position_{0.0, 0.0, 0.0};  // of the row that was read last
  Vec3s color_{0.f, 0.f, 0.f};     // of the same row
  std::vector<double> corners_;
};

}  // namespace

/// Reads text and binary PLY of either byte order, any number types, faces and triangle strips. Colours are
/// the points' own, else the faces' (strips have none and are white then); integers are divided by the
/// largest value of their type. Everything else is ignored. (Assimp reads no colours of faces, and reads
/// garbage where an element that it does not know comes before the points.)
StoredMesh readPly(const std::string& path, std::string_view file) {
  std::string memory;
  const std::string_view bytes = plainText(file, memory);
  const PlyHeader header = readPlyHeader(path, bytes);
  checkPlyBody(path, bytes, header);
  StoredMesh stored = PlyReader(path, bytes, header).read();
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") stored.points = element.count;
    if (element.name == "face") stored.faces = element.count;
  }
  return stored;
}

}  // namespace slicemorph

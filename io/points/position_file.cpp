#include "io/points/position_file.h"

#include "io/atomic_file.h"
#include "io/mesh/mesh_text.h"
#include "io/mesh/ply_check.h"
#include "io/mesh/ply_header.h"
#include "io/paths.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>

namespace slicemorph {

namespace {

using Field = PositionFile::Field;

constexpr int kDigits = 10;  ///< of written numbers: finer than single precision, which maps are computed in

/// Larger coordinates are no places: squares and differences of theirs would overflow.
constexpr double kLargestCoordinate = 1e15;

/// A number that fills the whole token and can be a coordinate.
bool isNumber(std::string_view token, double& value) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  const auto result = std::from_chars(token.data(), token.data() + token.size(), value);
  return result.ec == std::errc() && result.ptr == token.data() + token.size() &&
         std::abs(value) < kLargestCoordinate;
}

/// The parts of a line that are separated by any of `marks`; blanks and quotes around parts are left out. Between
/// double quotes marks do not count. `merged`: several marks in a row are one.
std::vector<std::string_view> partsOf(std::string_view line, std::string_view marks, bool merged) {
  std::vector<std::string_view> parts;
  size_t begin = 0;
  bool quoted = false;
  for (size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (quoted || marks.find(line[i]) == std::string_view::npos)) continue;
    std::string_view part = trimmed(line.substr(begin, i - begin));
    if (part.size() > 1 && part.front() == '"' && part.back() == '"') part = part.substr(1, part.size() - 2);
    if (!merged || !part.empty()) parts.push_back(part);
    begin = i + 1;
  }
  return parts;
}

/// Which coordinate a table's column is by its heading, as `x`, `Px`, `pos_x`, `x [mm]`, `Points:0`; -1: none.
int axisOf(std::string_view heading) {
  std::string name = lowered(std::string(heading));
  if (const size_t unit = name.find_first_of("[("); unit != std::string::npos) name.erase(unit);
  while (!name.empty() && isSpace(name.back())) name.pop_back();
  if (name.empty()) return -1;
  const char last = name.back();
  name.pop_back();
  while (!name.empty() && std::strchr("._: ", name.back())) name.pop_back();
  static const char* const kStems[] = {"", "p", "pos", "position", "point", "points", "coord", "coordinate"};
  if (std::find(std::begin(kStems), std::end(kStems), name) == std::end(kStems)) return -1;
  if (last >= 'x' && last <= 'z') return last - 'x';
  return !name.empty() && last >= '0' && last <= '2' ? last - '0' : -1;
}

/// Whether a "CoordinateSystem" comment of 3D Slicer says RAS, by name or, in older versions, as 0.
bool saysRas(std::string_view comment) {
  return comment.find("RAS") != std::string_view::npos || comment.find("= 0") != std::string_view::npos;
}

}  // namespace

/// Finds the positions of a file.
class PositionScanner {
 public:
  PositionScanner(PositionFile& file) : file_(file), path_(file.path_) {}

  void scan() {
    const std::string extension = extensionOf(path_);
    if (extension == ".ply")
      scanPly();
    else if (extension == ".off")
      scanOff();
    else if (extension == ".obj")
      eachLine([&](std::string_view line) { scanObjLine(line); });
    else if (extension == ".glb")
      takeGltf();
    else if (extension == ".csv")
      scanTable();
    else if (extension == ".fcsv")
      scanSlicer();
    else
      scanLandmarks();
    if (file_.positions_.empty()) throw InputError(path_, "holds no points");
    if (file_.ras_)
      for (Vec3d& p : file_.positions_) p[0] = -p[0], p[1] = -p[1];
  }

 private:
  using Parts = std::array<std::string_view, 3>;

  void takeGltf() {
    file_.gltf_ = std::make_shared<const GltfPositions>(path_, file_.bytes_);
    file_.positions_ = file_.gltf_->positions();
    file_.normals_ = file_.gltf_->hasNormals();
  }

  size_t offsetOf(std::string_view part) const { return size_t(part.data() - file_.bytes_.data()); }

  [[noreturn]] void refuseLine(const std::string& why) const {
    const std::string where =
        line_ > 0 ? std::to_string(line_) : " point " + std::to_string(file_.positions_.size() + 1);
    throw InputError(path_ + ":" + where + ": " + why);
  }

  /// Whether a number can be that of the file's points.
  bool isCount(double value) const {
    return value >= 0 && value <= double(file_.bytes_.size()) && value == std::floor(value);
  }

  /// Lines end with \n, \r\n or \r; a byte order mark is passed over. `whole`: with blanks around them.
  template <typename Visit>
  void eachLine(const Visit& visit, bool whole = false) {
    const std::string_view all = file_.bytes_;
    line_ = 0;
    for (size_t begin = all.substr(0, 3) == "\xEF\xBB\xBF" ? 3 : 0; begin < all.size();) {
      size_t end = all.find_first_of("\r\n", begin);
      if (end == std::string_view::npos) end = all.size();
      ++line_;
      const std::string_view line = all.substr(begin, end - begin);
      visit(whole ? line : trimmed(line));
      begin = end + (all.substr(end, 2) == "\r\n" ? 2 : 1);
    }
  }

  void add(const Parts& parts) {
    Vec3d p;
    for (int d = 0; d < 3; ++d) {
      if (!isNumber(parts[size_t(d)], p[d]))
        refuseLine("'" + std::string(parts[size_t(d)].substr(0, 40)) + "' stands for the number " + "xyz"[d]);
    }
    addPosition(p, parts);
  }

  void addPosition(const Vec3d& p, const Parts& parts) {
    file_.positions_.push_back(p);
    std::array<Field, 3> fields;
    for (int d = 0; d < 3; ++d) fields[size_t(d)] = {offsetOf(parts[size_t(d)]), parts[size_t(d)].size(), d};
    std::sort(fields.begin(), fields.end(), [](const Field& a, const Field& b) { return a.at < b.at; });
    file_.fields_.insert(file_.fields_.end(), fields.begin(), fields.end());
  }

  void scanObjLine(std::string_view line) {
    const std::vector<std::string_view> parts = partsOf(line, " \t", true);
    if (parts.empty()) return;
    if (parts[0] == "vn") file_.normals_ = true;
    if (parts[0] != "v") return;
    if (parts.size() < 4) refuseLine("expected v x y z, not '" + std::string(line.substr(0, 60)) + "'");
    add({parts[1], parts[2], parts[3]});
  }

  void scanOff() {
    double left = -1;  // points still to come; -1: the counts have not been read
    bool named = false;
    eachLine([&](std::string_view line) {
      line = line.substr(0, line.find('#'));
      std::vector<std::string_view> parts = partsOf(line, " \t", true);
      if (!named && !parts.empty()) {
        named = true;
        if (double number = 0; !isNumber(parts[0], number)) {
          if (parts.size() > 1 && parts[1] == "BINARY")
            throw InputError(path_, "is a binary OFF file; give it as text, or as .ply");
          file_.normals_ = parts[0].find('N') != std::string_view::npos;
          parts.erase(parts.begin());
        }
      }
      if (parts.empty() || left == 0) return;
      if (left < 0) {
        if (!isNumber(parts[0], left) || !isCount(left)) refuseLine("expected the number of points");
      } else {
        if (parts.size() < 3) refuseLine("expected x y z");
        add({parts[0], parts[1], parts[2]}), --left;
      }
    });
    if (left > 0) throw IoError(path_, "is truncated: " + std::to_string(long(left)) + " points are missing");
  }

  void scanTable() {
    char mark = 0;
    std::array<size_t, 3> column{};
    eachLine(
        [&](std::string_view line) {
          if (trimmed(line).empty() || line[0] == '#') return;
          const bool first = mark == 0;
          if (first) {
            mark = ',';
            for (char c : {';', '\t'})
              if (std::count(line.begin(), line.end(), c) > std::count(line.begin(), line.end(), mark))
                mark = c;
          }
          const std::vector<std::string_view> parts = partsOf(line, {&mark, 1}, false);
          if (first && namedColumns(parts, column)) return;
          const size_t last = *std::max_element(column.begin(), column.end());
          if (last >= parts.size())
            refuseLine("has " + std::to_string(parts.size()) + " columns; x, y and z reach to column " +
                       std::to_string(last + 1));
          add({parts[column[0]], parts[column[1]], parts[column[2]]});
        },
        true);
  }

  /// Finds the columns of x, y and z. Returns whether the line is one of headings.
  bool namedColumns(const std::vector<std::string_view>& parts, std::array<size_t, 3>& column) const {
    int found[3] = {-1, -1, -1};
    std::vector<size_t> numbers;
    for (size_t i = 0; i < parts.size(); ++i) {
      double value = 0;
      if (isNumber(parts[i], value)) numbers.push_back(i);
      if (const int axis = axisOf(parts[i]); axis >= 0 && found[axis] < 0) found[axis] = int(i);
    }
    if (found[0] >= 0 && found[1] >= 0 && found[2] >= 0) {
      for (size_t d = 0; d < 3; ++d) column[d] = size_t(found[d]);
      return true;
    }
    if (numbers.size() < 3) refuseLine("names no columns x, y and z, and does not hold three numbers");
    std::copy_n(numbers.begin(), 3, column.begin());
    return false;
  }

  void scanSlicer() {
    eachLine([&](std::string_view line) {
      if (takenAsComment(line)) return;
      const std::vector<std::string_view> parts = partsOf(line, ",", false);
      double value = 0;
      if (parts.size() < 4 || !isNumber(parts[1], value))
        refuseLine("no point: " + std::string(line.substr(0, 60)));
      add({parts[1], parts[2], parts[3]});
    });
  }

  bool takenAsComment(std::string_view line) {
    if (line.find("CoordinateSystem") != std::string_view::npos && line[0] == '#') file_.ras_ = saysRas(line);
    return line.empty() || line[0] == '#';
  }

  void scanLandmarks() {
    size_t stated = 0;
    eachLine([&](std::string_view line) {
      if (takenAsComment(line)) return;
      if (line == "index") throw InputError(path_, "holds voxel indices; give points in world units");
      std::vector<std::string_view> numbers;
      for (std::string_view part : partsOf(line, " \t,;", true))
        if (double value = 0; isNumber(part, value)) numbers.push_back(part);
      const bool none = file_.positions_.empty();
      if (none && numbers.empty()) return;  // a header
      if (none && numbers.size() == 1 && stated == 0) {
        double value = 0;
        isNumber(numbers[0], value);
        if (!isCount(value))
          refuseLine("expected the number of points, not '" + std::string(numbers[0]) + "'");
        stated = size_t(value);
      } else if (numbers.size() == 3) {
        add({numbers[0], numbers[1], numbers[2]});
      } else {
        refuseLine("expected x y z, not '" + std::string(line.substr(0, 60)) + "'");
      }
    });
    if (stated != 0 && stated != file_.positions_.size())
      throw InputError(path_, "states " + std::to_string(stated) + " points and holds " +
                                  std::to_string(file_.positions_.size()));
  }

  void scanPly() {
    const std::string_view all = file_.bytes_;
    const PlyHeader header = readPlyHeader(path_, all);
    checkPlyBody(path_, all, header);
    file_.binary_ = !header.text, file_.bigEndian_ = header.bigEndian;
    Text text(all.substr(header.size));
    size_t at = header.size;
    for (const PlyElement& element : header.elements) {
      const bool points = element.name == "vertex";
      const std::array<int, 4> known = points ? knownProperties(element) : std::array<int, 4>{-1, -1, -1, -1};
      for (std::uint64_t row = 0; row < element.count; ++row) {
        Parts parts;
        for (size_t i = 0; i < element.properties.size(); ++i) {
          const PlyProperty& property = element.properties[i];
          const std::string_view part =
              header.text ? textValue(text, property) : binaryValue(at, property, header.bigEndian);
          for (size_t d = 0; d < 3; ++d)
            if (known[d] == int(i)) parts[d] = part;
        }
        if (points) header.text ? add(parts) : addBinary(parts);
      }
      if (points) return;
    }
  }

  /// The properties that are x, y and z; notes whether there are normals.
  std::array<int, 4> knownProperties(const PlyElement& element) {
    std::array<int, 4> known{-1, -1, -1, -1};
    for (size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (property.name == "nx") file_.normals_ = true;
      for (size_t d = 0; d < 3; ++d)
        if (property.name == std::string(1, "xyz"[d]) && !property.isList()) {
          known[d] = int(i);
          if (!property.type.real)
            throw InputError(path_,
                             "has whole numbers as positions, which cannot hold others; give it with floats");
        }
    }
    if (known[0] < 0 || known[1] < 0 || known[2] < 0)
      throw IoError(path_, "is damaged: its vertices have no x, y and z");
    return known;
  }

  static std::string_view textValue(Text& text, const PlyProperty& property) {
    std::string_view token = text.token();
    if (!property.isList()) return token;
    std::uint64_t items = 1;  // as checkPlyBody counts them
    parse(token, items);
    for (; items > 0; --items) text.token();
    return {};
  }

  std::string_view binaryValue(size_t& at, const PlyProperty& property, bool bigEndian) const {
    const std::string_view all = file_.bytes_;
    size_t items = 1;
    if (property.isList()) {
      items = 0;
      for (int i = 0; i < property.count.size; ++i) {
        const size_t from = at + size_t(bigEndian ? i : property.count.size - 1 - i);
        items = items << 8 | static_cast<unsigned char>(all[from]);
      }
      at += size_t(property.count.size);
    }
    const std::string_view value = all.substr(at, size_t(property.type.size));
    at += items * size_t(property.type.size);
    return value;
  }

  void addBinary(const Parts& parts) {
    Vec3d p;
    for (int d = 0; d < 3; ++d) {
      char bytes[8];
      const std::string_view part = parts[size_t(d)];
      std::memcpy(bytes, part.data(), part.size());
      if (file_.bigEndian_) std::reverse(bytes, bytes + part.size());
      if (part.size() == 4) {
        float value;
        std::memcpy(&value, bytes, 4);
        p[d] = value;
      } else {
        std::memcpy(&p[d], bytes, 8);
      }
      if (!(std::abs(p[d]) < kLargestCoordinate))
        throw IoError(path_, "point " + std::to_string(file_.positions_.size() + 1) + " is no place");
    }
    addPosition(p, parts);
  }

  PositionFile& file_;
  const std::string& path_;
  size_t line_ = 0;
};

const std::vector<std::string>& positionExtensions() {
  static const std::vector<std::string> extensions{".obj", ".ply", ".off", ".glb",
                                                   ".csv", ".txt", ".pts", ".fcsv"};
  return extensions;
}

std::string positionList() {
  std::string list;
  for (const std::string& extension : positionExtensions()) list += (list.empty() ? "" : " ") + extension;
  return list;
}

PositionFile::PositionFile(const std::string& path) : path_(path), bytes_(readWholeFile(path)) {
  PositionScanner(*this).scan();
}

void PositionFile::write(const std::string& path, const std::vector<Vec3d>& positions) const {
  if (extensionOf(path) != extensionOf(path_))
    throw InputError(path, "is a copy of " + path_ + " with other positions and keeps its extension '" +
                               extensionOf(path_) + "'");
  AtomicFile out(path);
  if (gltf_) {
    out.write(gltf_->with(positions));
    out.commit();
    return;
  }
  size_t written = 0;
  for (size_t i = 0; i < fields_.size(); ++i) {
    const Field& field = fields_[i];
    double value = positions[i / 3][field.axis];
    if (ras_ && field.axis < 2) value = -value;
    out.write(std::string_view(bytes_).substr(written, field.at - written));
    char text[32];
    size_t length = field.length;
    if (binary_) {
      const float single = float(value);
      std::memcpy(text, length == 4 ? static_cast<const void*>(&single) : &value, length);
      if (bigEndian_) std::reverse(text, text + length);
    } else {
      length = size_t(
          std::to_chars(text, text + sizeof text, value, std::chars_format::general, kDigits).ptr - text);
    }
    out.write({text, length});
    written = field.at + field.length;
  }
  out.write(std::string_view(bytes_).substr(written));
  out.commit();
}

}  // namespace slicemorph

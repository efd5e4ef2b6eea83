#include "io/mesh/obj_scan.h"

#include "io/mesh/mesh_text.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// More than fit in a file of 2 GiB, the most that is read (mesh_reader.cpp).
constexpr std::uint64_t kMostVertices = std::uint64_t(2) << 30;

class ObjScan {
 public:
  ObjScan(const std::string& path, std::string_view bytes) : path_(path), text_(bytes) {
    counts_.endsInLine = bytes.back() != '\n';
  }

  ObjCounts run() {
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
    // Assimp gives faces without a material the last one of the .mtl file.
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
    if (index > kMostVertices) return;  // refused at the end: no file has so many vertices
    if (index >= used_.size()) used_.resize(std::max<size_t>(index + 1, counts_.points + 1), false);
    used_[index] = true;
  }

  const std::string& path_;
  Text text_;
  ObjCounts counts_;
  std::vector<bool> used_;
  size_t colored_ = 0;
  bool usesMaterials_ = false;
  std::uint64_t highest_ = 0;
  size_t highestLine_ = 0;
};

}  // namespace

ObjCounts scanObj(const std::string& path, std::string_view bytes) { return ObjScan(path, bytes).run(); }

}  // namespace slicemorph

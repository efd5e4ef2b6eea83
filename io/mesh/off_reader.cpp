#include "io/mesh/assimp_scene.h"
#include "io/mesh/mesh_text.h"

#include <algorithm>

namespace slicemorph {
namespace {

struct OffCounts {
  size_t points = 0, faces = 0;
};

/// Lines of an OFF file without comments; empty ones are skipped.
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

OffCounts checkOff(const std::string& path, std::string_view bytes) {
  OffLines lines(bytes);
  std::string_view line = lines.next();
  Text first(line);
  if (first.token().find("OFF") == std::string_view::npos)
    refuse(path, "is no OFF file: it does not begin with 'OFF'");
  Text counts = tokenCount(line) > 1 ? first : Text(lines.next());
  OffCounts result;
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

}  // namespace

StoredMesh readOff(const std::string& path, std::string_view bytes) {
  const OffCounts counts = checkOff(path, bytes);
  StoredMesh stored = importScene(path);
  stored.points = counts.points, stored.faces = counts.faces;
  return stored;
}

}  // namespace slicemorph

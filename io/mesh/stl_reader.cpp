#include "io/mesh/assimp_scene.h"
#include "io/mesh/mesh_text.h"

#include <cstring>

namespace slicemorph {
namespace {

struct StlCounts {
  size_t points = 0, faces = 0;
};

std::uint32_t countAt(std::string_view bytes, size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

StlCounts checkStlText(const std::string& path, std::string_view bytes) {
  StlCounts counts;
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

StlCounts checkStl(const std::string& path, std::string_view bytes) {
  // Binary headers may begin with 'solid' too: the size decides.
  const bool binarySized = bytes.size() >= 84 && bytes.size() == 84 + 50 * std::uint64_t(countAt(bytes, 80));
  const bool text = bytes.substr(0, 5) == "solid" && bytes.find('\0') == std::string_view::npos;
  if (text && !binarySized) return checkStlText(path, bytes);
  if (bytes.size() < 84) refuseTruncated(path, "a binary STL begins with 84 bytes");
  const std::uint64_t count = countAt(bytes, 80);
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
  return {size_t(count) * 3, size_t(count)};
}

}  // namespace

StoredMesh readStl(const std::string& path, std::string_view bytes) {
  const StlCounts counts = checkStl(path, bytes);
  StoredMesh stored = importScene(path);
  stored.points = counts.points, stored.faces = counts.faces;
  stored.mesh.importCopies = stored.mesh.points.size();  // the format has no shared points
  return stored;
}

}  // namespace slicemorph

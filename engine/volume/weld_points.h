#pragma once

#include "engine/volume/polygon_mesh.h"

#include <limits>

namespace slicemorph {

/// Index of a point that no face uses.
constexpr std::uint32_t kNoPoint = std::numeric_limits<std::uint32_t>::max();

struct WeldedPoints {
  std::vector<openvdb::Vec3s> points;   ///< distinct coordinates, in the order of first use
  std::vector<std::uint32_t> newIndex;  ///< of every old point; kNoPoint: no face uses it
  size_t unused = 0, merged = 0;        ///< with what the importer dropped; without what it copied
};

/// Makes points of equal coordinates one, and drops those that no face uses.
WeldedPoints weldPoints(const PolygonMesh& mesh);

}  // namespace slicemorph

#pragma once

#include "engine/volume/polygon_mesh.h"

#include <limits>

namespace slicemorph {

/// Index of a point that no face uses.
constexpr std::uint32_t kNoPoint = std::numeric_limits<std::uint32_t>::max();

struct WeldedPoints {
  std::vector<openvdb::Vec3s> points;   ///< distinct positions, in the order of first use
  std::vector<std::uint32_t> newIndex;  ///< of every old point; kNoPoint: no face uses it
  /// Unused points, including those that the importer dropped; merged points, without those
  /// that it duplicated.
  size_t unused = 0, merged = 0;
};

/// Merges points with equal coordinates and drops those that no face uses.
WeldedPoints weldPoints(const PolygonMesh& mesh);

}  // namespace slicemorph

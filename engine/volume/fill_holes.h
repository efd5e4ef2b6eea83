#pragma once

#include "slicemorph/mesh.h"

#include <cstdint>

namespace slicemorph {

/// Points around a hole, in the direction in which triangles that fill it run.
using PointLoop = std::vector<std::uint32_t>;

struct BoundaryLoops {
  std::vector<PointLoop> loops;
  size_t edges = 0;   ///< with one face
  size_t strays = 0;  ///< of them those that close no loop, because the winding disagrees there
};

/// The edges with one face as loops that pass no point twice.
BoundaryLoops findBoundary(const std::vector<openvdb::Vec3I>& triangles, size_t pointCount);

/// Lengths of the connected parts of the boundary, whatever the winding, world units: for surfaces whose boundary
/// makes no loops.
std::vector<double> boundaryParts(const Mesh& mesh);

double loopLength(const std::vector<openvdb::Vec3s>& points, const PointLoop& loop);

/// Adds the triangulation of least area of a closed polygon in space [BS95]. Of holes with more
/// than 400 edges a fan around their centroid: the search takes cubic time.
void fillHole(Mesh& mesh, const PointLoop& loop);

}  // namespace slicemorph

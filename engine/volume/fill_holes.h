#pragma once

#include "slicemorph/mesh.h"

#include <cstdint>

namespace slicemorph {

/// Points around a hole, in the order in which the filling triangles run.
using PointLoop = std::vector<std::uint32_t>;

struct BoundaryLoops {
  std::vector<PointLoop> loops;
  size_t edges = 0;   ///< number of edges with one face
  size_t strays = 0;  ///< those of them that are part of no loop, because windings disagree there
};

/// The edges with one face, as loops that visit no point twice.
BoundaryLoops findBoundary(const std::vector<openvdb::Vec3I>& triangles, size_t pointCount);

/// Lengths (world units) of the connected parts of the boundary, whatever the winding; for surfaces whose
/// boundary does not form loops.
std::vector<double> boundaryParts(const Mesh& mesh);

double loopLength(const std::vector<openvdb::Vec3s>& points, const PointLoop& loop);

/// Fills a hole with the triangulation of least area [BS95]. Holes with more than 400 edges get a fan around
/// their centroid instead, because the search takes cubic time.
void fillHole(Mesh& mesh, const PointLoop& loop);

}  // namespace slicemorph

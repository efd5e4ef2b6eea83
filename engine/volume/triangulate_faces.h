#pragma once

#include "engine/volume/weld_points.h"

namespace slicemorph {

struct TriangulatedFaces {
  std::vector<openvdb::Vec3I> triangles;
  /// Faces with more than three corners; faces that were dropped.
  size_t polygons = 0, degenerate = 0, duplicate = 0;
};

/// The faces of a mesh as triangles of its welded points. Degenerate triangles are dropped, and those with
/// the same three points as an earlier one, whatever the winding.
TriangulatedFaces triangulateFaces(const PolygonMesh& mesh, const WeldedPoints& welded);

}  // namespace slicemorph

#pragma once

#include "engine/volume/weld_points.h"

namespace slicemorph {

struct TriangulatedFaces {
  std::vector<openvdb::Vec3I> triangles;
  size_t polygons = 0, degenerate = 0, duplicate = 0;  ///< faces of more than three corners; faces left out
};

/// The faces of a mesh as triangles of its welded points, without degenerate ones and those whose three points another
/// one has, whatever the winding.
TriangulatedFaces triangulateFaces(const PolygonMesh& mesh, const WeldedPoints& welded);

}  // namespace slicemorph

#pragma once

#include "slicemorph/mesh.h"

namespace slicemorph {

/// Empty where there are no points.
openvdb::BBoxd boundsOf(const std::vector<openvdb::Vec3s>& points);

/// The largest coordinate of a box by its amount, on either side of 0.
double farthestCoordinate(const openvdb::BBoxd& box);

/// Sum of the triangles' areas, world units squared.
double areaOf(const Mesh& mesh);

}  // namespace slicemorph

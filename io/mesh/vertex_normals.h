#pragma once

#include "slicemorph/conventions.h"

#include <vector>

namespace slicemorph {

/// Unit vertex normals: the mean of the adjacent triangles' normals, weighted by area. A vertex without a
/// triangle of any area takes its normal of `instead`, or +Z where that is null.
std::vector<openvdb::Vec3s> vertexNormals(const std::vector<openvdb::Vec3I>& triangles,
                                          const std::vector<openvdb::Vec3s>& points,
                                          const std::vector<openvdb::Vec3s>* instead = nullptr);

}  // namespace slicemorph

#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>

namespace slicemorph {

/// Triangulates a face of three corners or more by ear clipping [Mei75], so that concave faces keep their
/// outline. Works in the plane of the face's Newell normal.
std::vector<openvdb::Vec3I> clipEars(const std::vector<openvdb::Vec3s>& points,
                                     const std::vector<std::uint32_t>& face);

}  // namespace slicemorph

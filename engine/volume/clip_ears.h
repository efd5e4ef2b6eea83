#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>

namespace slicemorph {

/// Triangles of a face of three corners or more, by ear clipping [Mei75]: concave faces keep their outline.
/// A face is looked at in the plane that its corners are nearest to.
std::vector<openvdb::Vec3I> clipEars(const std::vector<openvdb::Vec3s>& points,
                                     const std::vector<std::uint32_t>& face);

}  // namespace slicemorph

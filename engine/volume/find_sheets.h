#pragma once

#include "engine/volume/winding_number.h"

namespace slicemorph {

/// What a shell must have of its area as a wall to enclose something by itself: on one side the winding number is near
/// 0, on the other near 1. A plane has none, a bowl half as deep as its radius none, a hemisphere a half, a boot with
/// a wide cuff .45.
constexpr double kLeastEnclosing = 0.125;
/// What it must have among all others to be a wall of something with them, if it encloses nothing by itself.
constexpr double kLeastWall = 0.5;

/// Shells (sets of triangles) that enclose nothing, neither alone nor together with the rest: a plane, a leaf, a
/// one-sided band. Six quads that only together are a cube are none. `all`: of the whole mesh. Returns their positions
/// among `shells`.
std::vector<size_t> findSheets(const Mesh& mesh, const std::vector<std::vector<std::uint32_t>>& shells,
                               const WindingNumber& all);

}  // namespace slicemorph

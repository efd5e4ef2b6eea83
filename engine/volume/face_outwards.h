#pragma once

#include "engine/volume/winding_number.h"

namespace slicemorph {

/// Turns patches (`patch`: per triangle, from AgreedWinding) whose backs are seen from outside where their fronts are
/// not: rays leave both sides, and those that get away vote [TJKS14]. Patches of which both sides are seen alike keep
/// their winding. Those of which nothing is seen, as walls of cavities, turn with those that enclose them. `rays`: of
/// the mesh as it is; the winding does not matter. Returns how many triangles were turned.
size_t faceOutwards(Mesh& mesh, const std::vector<std::uint32_t>& patch, const WindingNumber& rays);

/// The same for pieces of patches (`piece`: per triangle, from AgreedWinding): where faces were turned to agree with
/// their neighbours but are then seen from their backs, as where two surfaces were sewn onto each other, the vote
/// prevails.
size_t facePiecesOutwards(Mesh& mesh, const std::vector<std::uint32_t>& piece, const WindingNumber& rays);

}  // namespace slicemorph

#pragma once

#include "engine/reconstruct/plane_section.h"

namespace slicemorph {

/// A function on a section's pixels that is the distance times `slopes` (one an edge) on the contours and has
/// least bending between them, up to `reach` world units away; beyond it the distance times the slope. A body
/// of constant section then is what bends least between two planes: with plain distances, which have a crease
/// in the middle of a limb, thin limbs would swell at the planes.
std::vector<float> planeProfile(const PlaneImage& image, const std::vector<float>& slopes, double reach);

}  // namespace slicemorph

#pragma once

#include "engine/reconstruct/plane_section.h"

namespace slicemorph {

/// A function on a section's pixels that equals the distance times the slope near the contours and has least
/// bending energy between them, up to `reach` world units away; beyond that it is the distance times the
/// slope. `slopes`: one per edge. Between two planes a body of constant cross-section then is the function of
/// least bending. Plain distances have a crease in the middle of a limb, with which thin limbs would swell at
/// the planes.
std::vector<float> planeProfile(const PlaneImage& image, const std::vector<float>& slopes, double reach);

}  // namespace slicemorph

#pragma once

#include "slicemorph/guidance.h"

#include <string>
#include <vector>

namespace slicemorph {

/// A point that all inputs have: its position on each, world units.
using Landmark = std::vector<Vec3d>;

/// Landmarks as point features named `landmark 1`, `landmark 2`, ...
std::vector<Feature> featuresOf(const std::vector<Landmark>& landmarks);

/// Landmarks of `inputs` objects from an option's text: a file of points per input, separated by commas
/// (anything that PositionFile reads; world units), or the positions themselves, `x,y,z=x,y,z;x,y,z=x,y,z`.
/// None where the text is empty. Throws InputError, IoError.
std::vector<Landmark> readLandmarks(const std::string& option, const std::string& text, size_t inputs);

}  // namespace slicemorph

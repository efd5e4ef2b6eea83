#pragma once

#include "slicemorph/guidance.h"

#include <string>
#include <vector>

namespace slicemorph {

/// A place that all inputs have: per input, world units.
using Landmark = std::vector<Vec3d>;

/// Landmarks as point features named `landmark 1`, `landmark 2`, ...
std::vector<Feature> featuresOf(const std::vector<Landmark>& landmarks);

/// Landmarks of `inputs` objects from what an option says: a file of points for every input, separated by
/// commas (a point a line, x y z in world units as the first or after a label; headers of elastix point files
/// and 3D Slicer .fcsv are known, RAS ones become LPS), or the places themselves, `x,y,z=x,y,z;x,y,z=x,y,z`.
/// None where the text is empty. Throws InputError, IoError.
std::vector<Landmark> readLandmarks(const std::string& option, const std::string& text, size_t inputs);

}  // namespace slicemorph

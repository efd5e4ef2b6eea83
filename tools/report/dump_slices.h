#pragma once

#include "slicemorph/slicemorph.h"

#include <string>
#include <vector>

namespace slicemorph {

/// Each slice of a plan as an SVG, drawn as dumpSlices does. `objectNames`: a name for each object.
std::vector<std::string> drawSlices(const std::vector<SlicePicture>& slices,
                                    const std::vector<std::string>& objectNames);

/// Draws each slice of a plan as `DIR/slice.0001.svg` and on: the objects side by side in chart space at one
/// scale; matched contours share a colour, unmatched ones are grey and dashed, holes are drawn thin; accepted
/// pairs are joined by a line between their centroids. Makes the folder where it is missing. Throws IoError.
void dumpSlices(const std::string& folder, const std::vector<SlicePicture>& slices,
                const std::vector<std::string>& objectNames);

}  // namespace slicemorph

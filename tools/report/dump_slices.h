#pragma once

#include "slicemorph/slicemorph.h"

#include <string>
#include <vector>

namespace slicemorph {

/// The SVGs that dumpSlices writes, one per slice of a plan. `objectNames`: a name for each object.
std::vector<std::string> drawSlices(const std::vector<SlicePicture>& slices,
                                    const std::vector<std::string>& objectNames);

/// Draws each slice of a plan as `DIR/slice.0001.svg` and so on: the objects side by side in chart space at
/// one scale; matched contours share a colour, unmatched ones are grey and dashed, holes have thin lines;
/// pairs are joined by a line between their centroids. Makes the folder if it is missing. Throws IoError.
void dumpSlices(const std::string& folder, const std::vector<SlicePicture>& slices,
                const std::vector<std::string>& objectNames);

}  // namespace slicemorph

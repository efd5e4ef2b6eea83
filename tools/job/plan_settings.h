#pragma once

#include "tools/job/landmarks.h"
#include "tools/job/option_set.h"

#include <string>
#include <vector>

/// How objects are matched, from the options of any command that does.
namespace slicemorph {

/// Most voxels along the longest side of shapes found in fog, where the shape only steers the map. Set by
/// hand: finer shapes cost time and do not help the matching, which works on coarser lattices.
constexpr int kFogResolution = 160;

/// --slices, --samples, --axis, --spine, --align, --interpolation, --upright, --voxel-size. `images`: all inputs are. `inputs`: how many there are.
/// Features and regions are not among them. Throws InputError.
MorphOptions planSettings(const OptionSet& options, bool images);

/// The landmarks of an option, `name`, whose value is `text`. Throws InputError, IoError.
std::vector<Landmark> landmarksOf(const OptionSet& options, const std::string& name, const std::string& text,
                                  size_t inputs);

/// Throws InputError where --iso has values for another number of inputs.
void checkIsos(const LoadOptions& load, const OptionSet& options, size_t inputs);

}  // namespace slicemorph

#pragma once

#include "slicemorph/io/placing.h"
#include "slicemorph/note.h"

#include <string>
#include <vector>

/// Inputs of different sizes and places, and how they are brought to one: --fit.
namespace slicemorph {

enum class FitKind { kNone, kSize, kBox };

/// How an input is to be fitted: as its own name says, else as the job does.
FitKind fitOf(const InputPlacing& own, const std::string& ofJob);

/// Box of where a level set's surface crosses the lines between voxels, world units.
openvdb::BBoxd boxOfShape(const FloatGrid& levelSet);

/// The placing of each input that brings it to the longest side of the first (kSize, about its own middle) and into the
/// middle of its box (kBox).
std::vector<Placing> fittingPlacings(const std::vector<openvdb::BBoxd>& boxes,
                                     const std::vector<FitKind>& fits);

/// A warning where inputs that are not fitted differ by more than a factor of 20, with both sizes.
Notes notesOnSizes(const std::vector<openvdb::BBoxd>& boxes, const std::vector<FitKind>& fits,
                   const std::vector<std::string>& names);

/// What was done to an input.
Note noteOnPlacing(const Placing& placing, const std::string& name);

}  // namespace slicemorph

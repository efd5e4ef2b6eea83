#pragma once

#include "tools/job/make_frame.h"

namespace slicemorph {

/// Chooses the voxels of in-between images: those of --like, else the first input's, extended as the other
/// shapes need; resampled to the voxel size or resolution if one is given. Throws InputError where labels are
/// mixed with grey values; IoError.
ImagePlan planImages(const MorphSettings& settings, const std::vector<LoadedObject>& inputs);

/// A frame's image: labels or grey values, as its inputs are.
Image imageBetween(const FrameTask& task);

}  // namespace slicemorph

#pragma once

#include "tools/job/make_frame.h"

namespace slicemorph {

/// Chooses the voxels of in-between images: those of --like, of the size that was asked for, or of the first
/// input and around it. Throws InputError where labels meet grey values, IoError.
ImagePlan planImages(const MorphSettings& settings, const std::vector<LoadedObject>& inputs);

/// A frame's image, by labels or grey values as its inputs are.
Image imageBetween(const FrameTask& task);

}  // namespace slicemorph

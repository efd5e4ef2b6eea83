#pragma once

#include "tools/job/methods.h"
#include "tools/job/morph_settings.h"

#include <memory>
#include <vector>

/// What the plans of the classic methods have in common.
namespace slicemorph {

/// Of all frames: the one that is asked for, else the finest input's; world units.
double commonVoxelSize(const MethodTask& task);

/// What the inputs' files hold, as plans take it.
std::vector<Object> objectsOf(const MethodTask& task);

/// The inputs' level sets.
std::vector<FloatGrid::ConstPtr> gridsOf(const MethodTask& task);

/// The plan of a method whose class makes frames of weights alone.
template <typename Morph>
MethodPlan planOf(std::shared_ptr<const Morph> morph) {
  return {[morph](const FrameJob& job) { return InBetween{morph->frame(job.weights), 0}; }};
}

}  // namespace slicemorph

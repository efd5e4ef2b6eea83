#pragma once

#include "slicemorph/io/output.h"
#include "tools/job/frame_inputs.h"
#include "tools/job/job_events.h"
#include "tools/job/make_frame.h"

#include <optional>
#include <vector>

namespace slicemorph {

/// Goes along the frames of a job, whatever its method: reads the inputs and plans whenever they change.
class FrameMaker {
 public:
  FrameMaker(const MorphSettings& settings, JobEvents& events);

  /// Reads and plans what a frame (index into the settings' frames) needs; frames are to come in order.
  /// `from`, `to`: this step's part of the whole job, for the progress.
  void moveTo(size_t index, double from, double to);

  /// Of the frame moved to; see make_frame.h.
  FrameTask task() const { return {settings_, inputs_.loaded(), plan_, settings_.frames[index_]}; }
  const std::vector<LoadedObject>& inputs() const { return inputs_.loaded(); }
  const MethodPlan& plan() const { return plan_.method; }
  /// The matched slices of all frames; null where each has its own, or the method none.
  const MorphPlan* commonPlan() const { return settings_.moving() ? nullptr : plan_.method.slices.get(); }

  struct Seconds {
    double load = 0, plan = 0;
  };
  Seconds seconds() const { return seconds_; }

 private:
  const MorphSettings& settings_;
  JobEvents& events_;
  FrameInputs inputs_;
  size_t index_ = 0;
  bool planned_ = false;  ///< the first plan is made
  FramePlan plan_;
  Seconds seconds_;
};

/// File metadata and compression of the output: the first VDB input's.
VdbOutput fileOptionsOf(const std::vector<LoadedObject>& inputs);

}  // namespace slicemorph

#pragma once

#include "slicemorph/io/output.h"
#include "tools/job/frame_inputs.h"
#include "tools/job/job_events.h"
#include "tools/job/make_frame.h"

#include <optional>
#include <vector>

namespace slicemorph {

/// Steps through the frames of a job: reads the inputs, and plans whenever they change.
class FrameMaker {
 public:
  /// `grid`: see FrameInputs.
  FrameMaker(const MorphSettings& settings, JobEvents& events, const std::string& grid = "");

  /// Reads and plans what a frame (index into the settings' frames) needs; frames must come in order. `from`,
  /// `to`: this step's part of the whole job, 0 to 1, for the progress.
  void moveTo(size_t index, double from, double to);
  /// The same of a frame of the inputs, whether a frame of the job shows it or not. `number`: for messages.
  void planFor(size_t inputFrame, int number, double from, double to);

  /// Spares reading the files that another stretch of the same sequences has just loaded.
  void takeFilesFrom(const FrameMaker& other) { inputs_.takeFrom(other.inputs_); }

  /// A neighbouring stretch of a sequence; null: there is none. `ratio`: how long this stretch is against it.
  struct Neighbour {
    const FrameMaker* maker;
    double ratio;
  };
  /// Makes paths go on smoothly from the stretch before and into the one after; see MorphPlan::passSmoothly.
  void passSmoothly(const Neighbour& before, const Neighbour& after);

  /// The task of the current frame; see make_frame.h.
  FrameTask task() const { return taskOf(settings_.frames[index_]); }
  FrameTask taskOf(const FrameJob& job) const { return {settings_, inputs_.loaded(), plan_, job}; }
  const std::vector<LoadedObject>& inputs() const { return inputs_.loaded(); }
  const MethodPlan& plan() const { return plan_.method; }
  /// The plan that all frames share; null where inputs change from frame to frame, or the method
  /// matches no slices.
  const MorphPlan* commonPlan() const { return settings_.moving() ? nullptr : plan_.method.slices.get(); }

  struct Seconds {
    double load = 0, plan = 0;
  };
  Seconds seconds() const { return seconds_; }
  /// The options of the plans: the settings', completed by what was found in the first inputs.
  const MorphOptions& options() const { return options_; }

 private:
  void complete();

  const MorphSettings& settings_;
  JobEvents& events_;
  FrameInputs inputs_;
  MorphOptions options_;
  size_t index_ = 0;
  bool planned_ = false;          ///< there is a plan
  std::optional<int> firstPlan_;  ///< of plans in numbered files, the number of the first frame's
  FramePlan plan_;
  Seconds seconds_;
};

/// File metadata and compression of the output: the first VDB input's.
VdbOutput fileOptionsOf(const std::vector<LoadedObject>& inputs);

}  // namespace slicemorph

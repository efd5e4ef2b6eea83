#pragma once

#include "slicemorph/io/placing.h"
#include "tools/job/frame_maker.h"
#include "tools/job/morph_job.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// A morph whose frames are made in memory, in any order, as a host asks for them. Frames, and files made of them, are the
/// same as those that runMorph() writes. One call at a time.
class MorphSession {
 public:
  /// Checks the options of `morph`, reads the inputs (of sequences those of the first frame) and plans. The output's name
  /// says what frames hold: grids, an image or a surface. Throws as morphJob and runMorph.
  MorphSession(const OptionSet& options, JobEvents& events);

  const MorphSettings& settings() const { return job_.settings; }
  /// Whether in-between images are maps of labels.
  bool makesLabels() const { return labels_; }
  const MethodPlan& method() const { return maker_->plan(); }
  /// The map of points; throws InputError where the method has none, and of sequences, where each frame has its own.
  const MorphPlan& plan() const;

  /// The frame at a time, 0 to 1. Its speed is that of a sequence of as many frames as the options say. Throws InputError.
  FrameJob frameAt(double t) const;
  /// One blend, without a speed; a weight for each input. Throws InputError.
  FrameJob blendOf(const Weights& weights) const;
  /// The frames of the job; `count`: evenly spaced ones instead, as of `morph --frames`. Throws InputError.
  std::vector<FrameJob> frames(std::optional<int> count) const;
  /// The weights at a time, 0 to 1. Throws InputError.
  Weights weightsOf(double t) const;

  /// Makes a frame. Of sequences the plans of all frames before it are made first, if they are not made. Throws as
  /// runMorph.
  MorphFrame make(const FrameJob& job, JobEvents& events);
  /// The shape of a frame, whether the output holds it or not. Throws InputError where the method makes none.
  MorphFrame shapeOf(const FrameJob& job, JobEvents& events);
  /// Writes a frame as grids, a mesh or an image by the path's extension. Throws as runMorph.
  void save(const std::string& path, const FrameJob& job, const MorphFrame& frame, JobEvents& events);

 private:
  /// Passes events on to the caller of the moment.
  class Relay : public JobEvents {
   public:
    void report(const char* stage, double fraction) override {
      if (to) to->report(stage, fraction);
    }
    bool cancelled() const override { return to && to->cancelled(); }
    void note(const Note& note) override {
      if (to) to->note(note);
    }
    JobEvents* to = nullptr;
  };

  void moveTo(size_t inputFrame, JobEvents& events);
  void checkTime(double t) const;
  [[noreturn]] void refuseShape() const;

  MorphJob job_;
  size_t length_ = 1;  ///< frames of the inputs
  Relay events_;
  std::unique_ptr<FrameMaker> maker_;
  std::optional<size_t> at_;  ///< frame of the inputs that is loaded and planned; none after a failure
  bool labels_ = false;       ///< the first input's frame is a map of labels
};

}  // namespace slicemorph

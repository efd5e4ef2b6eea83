#pragma once

#include "engine/follow/moving_mesh.h"
#include "tools/job/frame_images.h"
#include "tools/job/frame_maker.h"

#include <optional>
#include <vector>

namespace slicemorph {

/// Writes frames as the output's name says: grids, a mesh, an image, slices or a picture each, or all into one
/// animated .glb.
class FrameWriter {
 public:
  FrameWriter(const MorphSettings& settings, JobEvents& events) : settings_(settings), events_(events) {}

  /// Once the maker has been moved to the first frame. `done`: how much of the whole job that is.
  void prepare(const FrameMaker& maker, double done);
  /// Throws IoError, and what writing images throws.
  void write(const FrameTask& task, const MorphFrame& frame);
  /// Where all frames go into one file: writes it. `plan`: of all frames; null: there is none. `from`: how
  /// much of the job is done.
  void finish(const MorphPlan* plan, double from);

 private:
  const MorphSettings& settings_;
  JobEvents& events_;
  std::optional<ImageSetup> images_;
  std::vector<SurfaceFrame> surfaces_;  ///< of all frames, for one .glb
};

}  // namespace slicemorph

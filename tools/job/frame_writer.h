#pragma once

#include "engine/follow/moving_mesh.h"
#include "io/usd/usda_mesh.h"
#include "slicemorph/io/image_writer.h"
#include "tools/job/frame_images.h"
#include "tools/job/frame_maker.h"

#include <memory>
#include <optional>
#include <vector>

namespace slicemorph {

/// Writes frames in the form that the output's name asks for: grids, a mesh, an image, slices or a picture
/// each, or all frames in one animated .glb or .usda or one NIfTI file.
class FrameWriter {
 public:
  FrameWriter(const MorphSettings& settings, JobEvents& events) : settings_(settings), events_(events) {}

  /// To be called once the maker has been moved to the first frame. `done`: share of the job that is done,
  /// for the progress.
  void prepare(const FrameMaker& maker, double done);
  /// Throws IoError, and what writing images throws.
  void write(const FrameTask& task, const MorphFrame& frame);
  /// Writes the file if all frames go into one. `plan`: of all frames; null: there is none. `following`:
  /// of what that takes, 0 to 1.
  void finish(const MorphPlan* plan, Progress& following);

 private:
  void addVolume(const FrameTask& task, const Image& image);
  void addToUsda(const FrameTask& task, const MorphFrame& frame);
  void finishUsda();

  const MorphSettings& settings_;
  JobEvents& events_;
  std::optional<ImageSetup> images_;
  std::vector<SurfaceFrame> surfaces_;         ///< of all frames that are made, for one .glb
  std::vector<int> numbers_;                   ///< of these frames
  std::unique_ptr<UsdaMeshWriter> usda_;       ///< of all frames that are made, for one .usda
  std::unique_ptr<ImageSliceWriter> volumes_;  ///< of all frames that are made, for one NIfTI file
  std::optional<ImageLattice> lattice_;        ///< of these
};

}  // namespace slicemorph

#pragma once

#include "slicemorph/note.h"
#include "tools/job/frame_maker.h"

#include <string>
#include <vector>

namespace slicemorph {

/// Puts a morph's frames straight into images: EXR slices of their grids, or pictures of them. One camera,
/// one look and one stack of planes serve all frames.
class FrameImages {
 public:
  /// `cancel`: asked whether the job is to end.
  FrameImages(const MorphSettings& settings, const Progress& cancel) : settings_(settings), cancel_(cancel) {}

  /// Looks where the shapes will be in all frames and chooses camera, look or planes, once the maker has been
  /// moved to the first frame. Reads the files of sequences for that.
  void prepare(const FrameMaker& maker, Progress& progress);
  /// Throws IoError; InputError for planes that do not cut the shapes.
  void write(const FrameJob& job, const MorphFrame& frame);
  /// What was found and decided since the last call, one sentence each.
  Notes takeNotes() { return std::exchange(notes_, {}); }

 private:
  openvdb::BBoxd survey(const LoadedObject& input, bool asFog);
  openvdb::BBoxd surveyGrids(const LoadedObject& input);
  void surveyBetween(const FrameMaker& maker, const std::vector<openvdb::BBoxd>& reach);
  void writePictureOf(const FrameJob& job, const MorphFrame& frame);
  void writeSlicesOf(const FrameJob& job, const MorphFrame& frame);

  const MorphSettings& settings_;
  const Progress& cancel_;
  std::vector<openvdb::BBoxd> boxes_;  ///< world, of what is to be seen in all frames
  double finest_ = 0;                  ///< voxel size of the grids that are sliced, world units
  double fastest_ = 0;                 ///< world units from frame to frame
  std::vector<FogMeasure> fogs_;
  Camera camera_;
  FogLook look_;
  std::vector<SectionPlane> planes_;  ///< none where each frame has its own
  Notes notes_;
};

}  // namespace slicemorph

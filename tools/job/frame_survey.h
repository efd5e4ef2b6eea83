#pragma once

#include "engine/render/render_fog.h"
#include "tools/job/frame_maker.h"

#include <vector>

namespace slicemorph {

/// Boxes and other measures of all frames of a job, which its pictures or slices depend on.
struct FrameSurvey {
  std::vector<openvdb::BBoxd> boxes;  ///< world units, of what is shown in all frames
  double finest = 0;                  ///< voxel size of the grids that are sliced, world units; 0: none known
  double fastest = 0;                 ///< largest step of a point from frame to frame, world units
  std::vector<FogMeasure> fogs;       ///< of each input that is fog, or shown as fog
};

/// Surveys the inputs of all frames and follows the surfaces of the first ones through the map. The
/// maker must have been moved to the first frame. Reads the files of sequences. Throws as
/// loadObject, and Cancelled.
FrameSurvey surveyFrames(const MorphSettings& settings, const FrameMaker& maker, Progress& progress);

/// The box around all boxes.
openvdb::BBoxd boxAround(const std::vector<openvdb::BBoxd>& boxes);

}  // namespace slicemorph

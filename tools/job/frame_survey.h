#pragma once

#include "engine/render/render_fog.h"
#include "tools/job/frame_maker.h"

#include <vector>

namespace slicemorph {

/// Where a job's shapes are in all its frames, and what else pictures or slices of all of them depend on.
struct FrameSurvey {
  std::vector<openvdb::BBoxd> boxes;  ///< world, of what is to be seen in all frames
  double finest = 0;                  ///< voxel size of the grids that are sliced, world units; 0: none known
  double fastest = 0;                 ///< world units from frame to frame
  std::vector<FogMeasure> fogs;       ///< of each input that is fog, or is to look like it
};

/// Looks at the inputs of all frames, once the maker has been moved to the first one, and follows their
/// surfaces through the map. Reads the files of sequences for that. Throws as loadObject, Cancelled.
FrameSurvey surveyFrames(const MorphSettings& settings, const FrameMaker& maker, Progress& progress);

openvdb::BBoxd boxAround(const std::vector<openvdb::BBoxd>& boxes);

}  // namespace slicemorph

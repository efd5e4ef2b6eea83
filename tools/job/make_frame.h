#pragma once

#include "engine/measure/label_measures.h"
#include "slicemorph/label_field.h"
#include "slicemorph/slicemorph.h"
#include "tools/job/frame_content.h"
#include "tools/job/methods.h"
#include "tools/job/morph_settings.h"

#include <optional>
#include <vector>

namespace slicemorph {

/// What in-between images need of the inputs.
struct ImagePlan {
  ImageLattice lattice;            ///< of the results
  ImageHeader header;              ///< of the results' files
  std::vector<LabelField> labels;  ///< per input; none where these hold grey values
  Notes notes;
};

/// What all frames of the same inputs share.
struct FramePlan {
  FrameContent content;
  ImagePlan images;  ///< where the content has images
  MethodPlan method;
};

/// All that one frame is made from.
struct FrameTask {
  const MorphSettings& settings;
  const std::vector<LoadedObject>& inputs;
  const FramePlan& plan;
  const FrameJob& job;
};

/// One frame's shape and grids.
struct MorphFrame {
  InBetween shape;                      ///< surface null where the method makes none, or nothing needs it
  openvdb::GridCPtrVec grids;           ///< of an output that holds grids, in its order
  openvdb::Vec3SGrid::ConstPtr colors;  ///< of the shape's surface; null: it has none
  openvdb::GridBase::ConstPtr density;  ///< one of the grids: the shapes' fog; null: none
  std::optional<Image> image;           ///< of an image output
  std::vector<LabelMeasures> labels;    ///< of a map of labels, for a report
};

/// The shape, with its colours if it has some.
MorphFrame coloredShape(const FrameTask& task);
/// Makes all that the output holds. Throws Cancelled between two grids; InputError for grids that do not fit.
MorphFrame makeFrame(const FrameTask& task, const Progress& cancel);

/// The surface's value in the grey image of a frame.
double isoOf(const FrameTask& task);

}  // namespace slicemorph

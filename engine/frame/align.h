#pragma once

#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"
#include "slicemorph/note.h"
#include "slicemorph/slicemorph.h"

#include <optional>

namespace slicemorph {

using Fields = std::vector<std::shared_ptr<const DistanceField>>;

struct Frames {
  std::vector<Chart> charts;  ///< one per object
  double halfLength = 1;      ///< the common half length along the spine, chart units
  Notes notes;                ///< what was decided
};

/// A rotation that may carry one object's directions to another's.
struct Turn {
  Mat3d rotation = Mat3d::identity();
  double angle = 0;    ///< radians
  double overlap = 0;  ///< intersection over union of the two objects so turned, without position and size
};

/// The turns worth trying from object a to object b, the most likely first: the 24 proper axis assignments of
/// the oriented bounding boxes, the world's own directions and small turns away from these, scored by overlap
/// less a small price on the angle; then the quarter turns about `up`, unless that is zero. One only where
/// overlap alone decides. The same the other way round.
std::vector<Turn> proposeTurns(const DistanceField& a, const DistanceField& b, const Vec3d& up);

/// Price of a turn in overlap: what a morph must gain to be worth turning the object. Turns about `up` cost a
/// third of others; where it is zero nothing is up.
double priceOf(const Mat3d& rotation, const Vec3d& up);

/// Gives every object its chart, in the shared axes of all. `rotations`: from the first object's directions
/// to each object's; ignored where the options keep the world's. Symmetric in the objects' order.
Frames frameObjects(const Fields& fields, const std::vector<Mat3d>& rotations, const MorphOptions& options);

}  // namespace slicemorph

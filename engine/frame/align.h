#pragma once

#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"
#include "slicemorph/note.h"
#include "slicemorph/slicemorph.h"

#include <optional>

namespace slicemorph {

using Fields = std::vector<std::shared_ptr<const DistanceField>>;

/// The objects' coordinate frames (not frames of time).
struct Frames {
  std::vector<Chart> charts;        ///< one per object
  double halfLength = 1;            ///< the common half length along the spine, chart units
  std::vector<TurnChoice> choices;  ///< per object but the first
  Notes notes;                      ///< what was decided
};

/// A candidate rotation from one object's directions to another's.
struct Turn {
  Mat3d rotation = Mat3d::identity();
  double angle = 0;    ///< radians
  double overlap = 0;  ///< intersection over union of the objects so turned, centroids and sizes made equal
  bool likely = true;  ///< by overlap or by the up direction
};

/// The turns worth trying from object a to object b: none; the best of those refined from the 24 proper
/// assignments of the principal axes, by overlap minus a small price on the angle; and the quarter
/// turns about `up`, unless that is zero; then the other assignments, which are not likely. Only one turn where
/// overlap alone decides. Symmetric: b to a gives the inverse turns.
std::vector<Turn> proposeTurns(const DistanceField& a, const DistanceField& b, const Vec3d& up);

/// Price of a turn: the overlap that must be gained by turning an object. Turns about `up` cost a third of
/// others; zero: there is no such direction.
double priceOf(const Mat3d& rotation, const Vec3d& up);

/// Gives every object its chart with a straight spine, along axes shared by all. `rotations`: from the first
/// object's directions to each object's; ignored with Align::kNone. Symmetric in the objects' order.
Frames frameObjects(const Fields& fields, const std::vector<Mat3d>& rotations, const MorphOptions& options);

}  // namespace slicemorph

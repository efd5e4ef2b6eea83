#pragma once

#include "engine/blend/moving_lattice.h"
#include "engine/match/register.h"
#include "engine/shapes.h"

namespace slicemorph {

/// What a morph needs to know once; its frames are then made one by one.
struct Plan {
  MorphOptions options;
  Shapes shapes;
  Frames frames;
  TracedObjects traced;  ///< the shapes' contours; none where the plan goes on from an earlier one
  Registration registration;
  std::unique_ptr<MovingLattice> lattice;  ///< null: there is only one shape
  std::vector<Chart> drawn;                ///< the charts of the first frame, on which regions are drawn
};

/// The plan of a morph; see MorphPlan.
Plan planMorph(const std::vector<Object>& objects, const MorphOptions& options, Progress& progress);

/// The plan of the next frame of a sequence, which goes on from the one before where that is a start.
Plan planNext(const std::vector<Object>& objects, const Plan& before, Progress& progress);

/// The in-between of these weights of the objects.
InBetween makeInBetween(const Plan& plan, const Weights& weights);

}  // namespace slicemorph

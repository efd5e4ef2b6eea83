#pragma once

#include "engine/blend/moving_lattice.h"
#include "engine/match/register.h"
#include "engine/rebuild/in_between.h"
#include "engine/shapes.h"

namespace slicemorph {

/// What is computed once per morph, before its frames are made one by one.
struct Plan {
  MorphOptions options;
  Shapes shapes;
  Frames frames;         ///< coordinate frames of the shapes
  TracedObjects traced;  ///< the shapes' contours; empty if the plan continues an earlier one
  Registration registration;
  std::unique_ptr<MovingLattice> lattice;  ///< null if there is only one shape
  std::vector<Chart> drawn;                ///< the first frame's charts, in which regions are defined
};

/// The plan of a morph; see MorphPlan, also for what it throws.
Plan planMorph(const std::vector<Object>& objects, const MorphOptions& options, Progress& progress);

/// The plan of a sequence's next frame, continued from the one before, or made anew where that does not fit.
Plan planNext(const std::vector<Object>& objects, const Plan& before, Progress& progress);

/// The plan of a morph of which all but the objects' own measures was decided before, by plan_decisions.h; see
/// MorphPlan::decidedBefore.
Plan planDecided(const std::vector<Object>& objects, const MorphOptions& options,
                 const std::string& decisions, Progress& progress);

/// Whether a plan's two objects are densities that keep their positions and are laid on each other.
bool laysDensities(const Plan& plan);

/// The in-between of these weights of the objects.
RebuiltShape makeInBetween(const Plan& plan, const Weights& weights);

}  // namespace slicemorph

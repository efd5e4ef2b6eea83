#pragma once

#include "engine/match/contour_pairs.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// Objects that overlap by more than this lie on each other: neither bending nor soft matches, which find partners far
/// away, are tried. On balls, ellipsoids, boxes and people whose charts alone bring them so far no soft match was ever
/// taken.
constexpr double kLieOnEachOther = 0.96;

/// The state of the matching, passed from step to step.
struct Matching {
  Displacements map;                       ///< free of folds
  Displacements base;                      ///< to which each round adds a fitted smooth field
  std::vector<Correspondence> limbPoints;  ///< that hold followed limbs in position
  std::vector<MiddleGuess> guesses;  ///< per object, starts for toMiddle; empty while the map moves little
  double overlap = 0;                ///< of the objects warped by `map`, see mapOverlap
  double bonus = 0;                  ///< added to the overlap when matchings are compared
  bool swings = false;               ///< the map follows bodies that were bent onto each other: parts turn
  double softLoss = 0;               ///< what the last soft match would have cost in overlap; see refined
  Notes notes;

  double value() const { return overlap + bonus; }
};

}  // namespace slicemorph

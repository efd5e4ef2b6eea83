#pragma once

#include "engine/match/contour_pairs.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// The state of the matching: every step takes it from the one before and hands it on.
struct Matching {
  Displacements map;                       ///< free of folds
  Displacements base;                      ///< what the rounds' smooth fields are added to
  std::vector<Correspondence> limbPoints;  ///< that hold limbs where they were followed to
  std::vector<MiddleGuess> guesses;        ///< then, per object: where to look for middle points
  double overlap = 0;                      ///< of the objects so warped
  double bonus = 0;                        ///< what the map is worth beyond its overlap
  Notes notes;

  double value() const { return overlap + bonus; }
};

}  // namespace slicemorph

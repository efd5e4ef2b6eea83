#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

#include <string>

namespace slicemorph {

/// A gain in overlap that is no accident.
constexpr double kSureGain = 0.01;

/// What a map must gain in overlap to be taken: not at all at `none` or less, wholly from `all` on, in part
/// between, so that no decision hangs on the last digit.
struct GainWanted {
  double none = 0, all = kSureGain;
};

struct TakenMap {
  Matching matching;
  double share = 0;  ///< to which the map was taken, 0 to 1
};

/// Takes a map to the degree to which the objects warped by it overlap better than before. `name`: for the
/// note.
TakenMap takeAsFarAsBetter(const MatchObjects& objects, Matching matching, const Displacements& map,
                           const GainWanted& wanted, const std::string& name);

}  // namespace slicemorph

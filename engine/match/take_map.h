#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

#include <string>

namespace slicemorph {

/// A gain in overlap that counts as certain, not as noise. Chosen by hand.
constexpr double kSureGain = 0.01;

/// Gain in overlap up to which a map is not taken at all, and from which it is taken wholly; in between it is
/// taken in part (smoothstep), so that no decision depends on the last digit.
struct GainWanted {
  double none = 0, all = kSureGain;
};

struct TakenMap {
  Matching matching;
  double share = 0;    ///< to which the map was taken, 0 to 1
  double overlap = 0;  ///< of the map that was tried
};

/// Blends the matching's map with `map` by how much better the objects warped by `map` overlap. `name`: for
/// the note.
TakenMap takeAsFarAsBetter(const MatchObjects& objects, Matching matching, const Displacements& map,
                           const GainWanted& wanted, const std::string& name);

}  // namespace slicemorph

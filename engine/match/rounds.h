#pragma once

#include <vector>

namespace slicemorph {

/// One round of matching. Lengths are shares of the objects' size in chart space.
struct Round {
  enum class Kind { kSoft, kClosest };  ///< of the match: soft, or closest points
  Kind kind;
  double reach;      ///< blur of the soft match; or distance up to which a closest point counts
  double spacing;    ///< of the fitted lattice
  double stiffness;  ///< of the fit, for 2000 points
  int samples;       ///< per object
};

using Rounds = std::vector<Round>;

/// From coarse to fine: soft matches, which find partners far away, then closest points, which are exact near
/// by. What they must reach is in tests/engine/pairs_test.cpp.
inline const Rounds kWholeRounds{
    {Round::Kind::kSoft, 0.22, 0.25, 8, 900},        {Round::Kind::kSoft, 0.16, 0.20, 8, 900},
    {Round::Kind::kSoft, 0.12, 0.15, 6, 1400},       {Round::Kind::kSoft, 0.09, 0.12, 5, 1400},
    {Round::Kind::kSoft, 0.065, 0.09, 4, 2200},      {Round::Kind::kSoft, 0.05, 0.075, 3, 2200},
    {Round::Kind::kClosest, 0.20, 0.06, 2, 6000},    {Round::Kind::kClosest, 0.12, 0.05, 2, 6000},
    {Round::Kind::kClosest, 0.08, 0.045, 1.5, 8000}, {Round::Kind::kClosest, 0.06, 0.04, 1, 8000},
};

/// The same without the last, finest ones: where others follow on all objects (`refineRegistration`).
inline const Rounds kRoundsBeforeLast(kWholeRounds.begin(), kWholeRounds.end() - 2);

/// A look at how well objects can be matched at all.
inline const Rounds kQuickRounds{{Round::Kind::kClosest, 0.25, 0.14, 3, 1500},
                                 {Round::Kind::kClosest, 0.15, 0.10, 2, 1500}};

/// On top of a map that nearly holds: what a frame of a sequence changes since the one before.
inline const Rounds kFollowRounds{{Round::Kind::kClosest, 0.12, 0.06, 2, 6000},
                                  {Round::Kind::kClosest, 0.06, 0.045, 1.5, 8000}};

}  // namespace slicemorph

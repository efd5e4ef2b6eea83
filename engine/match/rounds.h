#pragma once

#include <vector>

namespace slicemorph {

/// One round of matching. Lengths are fractions of MatchObjects::size.
struct Round {
  enum class Kind { kSoft, kClosest };  ///< soft match, or closest points
  Kind kind;
  double reach;      ///< blur of the soft match; or distance up to which a closest point counts
  double spacing;    ///< of the fitted lattice
  double stiffness;  ///< of the fit, for 2000 points
  int samples;       ///< per object, if there are two
};

using Rounds = std::vector<Round>;

/// From coarse to fine: soft matches, which find partners far away, then closest points, which are
/// exact nearby. The figures, here and below, are chosen by hand; tests/engine/pairs_test.cpp says
/// what they must achieve.
inline const Rounds kWholeRounds{
    {Round::Kind::kSoft, 0.22, 0.25, 8, 900},        {Round::Kind::kSoft, 0.16, 0.20, 8, 900},
    {Round::Kind::kSoft, 0.12, 0.15, 6, 1400},       {Round::Kind::kSoft, 0.09, 0.12, 5, 1400},
    {Round::Kind::kSoft, 0.065, 0.09, 4, 2200},      {Round::Kind::kSoft, 0.05, 0.075, 3, 2200},
    {Round::Kind::kClosest, 0.20, 0.06, 2, 6000},    {Round::Kind::kClosest, 0.12, 0.05, 2, 6000},
    {Round::Kind::kClosest, 0.08, 0.045, 1.5, 8000}, {Round::Kind::kClosest, 0.06, 0.04, 1, 8000},
};

/// The same without the two finest rounds, for matchings that refineRegistration continues.
inline const Rounds kRoundsBeforeLast(kWholeRounds.begin(), kWholeRounds.end() - 2);

/// A quick estimate of how well objects can be matched.
inline const Rounds kQuickRounds{{Round::Kind::kClosest, 0.25, 0.14, 3, 1500},
                                 {Round::Kind::kClosest, 0.15, 0.10, 2, 1500}};

/// For a map that is nearly right already: the small changes from one frame of a sequence to the next.
inline const Rounds kFollowRounds{{Round::Kind::kClosest, 0.12, 0.06, 2, 6000},
                                  {Round::Kind::kClosest, 0.06, 0.045, 1.5, 8000}};

/// What is left of rounds once bodies were bent onto each other (`bentOntoEachOther`): the two finest.
inline Rounds roundsAfterBending(const Rounds& rounds) { return {rounds.end() - 2, rounds.end()}; }

}  // namespace slicemorph

#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

#include <functional>
#include <optional>

namespace slicemorph {

/// Two objects bent onto each other, or coupled.
struct Bending {
  bool bent = true;      ///< else coupled by inner distances, as bodies of one kind but of other proportions
  MatchObjects objects;  ///< with room in the middle space for what swings beyond both of them
  Matching matching;     ///< its map follows the bent bodies; its bonus is what having bent little is worth
  bool sure = false;     ///< nearly rigid, and all parts have a partner: nothing else need be tried
};

/// Bends two objects onto each other as rigidly as possible, as one body in two poses can be: limbs are followed
/// whole however far they swing, and points keep their place along them. Nothing for more objects, where features
/// prescribe where parts go, where the objects lie on each other already or are both compact, or where bending takes
/// much strain or leaves parts over, unless their inner distances show one kind of body: then these tell what belongs
/// together. The same whichever of the two is named first.
/// `matching`: whose map is changed. `limbCandidates`: matchings that may have followed limbs, by which the bodies may
/// lie on each other at first; called only where the objects' own positions leave doubt.
std::optional<Bending> bentOntoEachOther(const MatchObjects& objects, const Matching& matching,
                                         const std::function<const std::vector<Matching>&()>& limbCandidates);

}  // namespace slicemorph

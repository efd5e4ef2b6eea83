#pragma once

#include "engine/match/body_graph.h"

#include <array>
#include <limits>

namespace slicemorph {

/// Distortion of inner distances below which bodies are taken to be of one kind: coupled rightly they have .03 and less,
/// coupled wrongly .057 and more (the prototype's figures).
constexpr double kOneKind = 0.045;

/// A soft correspondence of two bodies' insides.
struct BodyCoupling {
  /// How much inner distances differ between points that belong together, in their mean squares; see kOneKind.
  double distortion = std::numeric_limits<double>::infinity();
  /// Per body (of two): where it is on the other one, in that one's coordinates. Nodes are turned no more than they have
  /// to be against those nearer to the body's middle, as round limbs show no twist.
  BodyPose pose[2];
  /// Points of both bodies and the mean places of what they are coupled to: per body, in its coordinates.
  std::vector<std::array<Vec3d, 2>> partners;
};

/// Couples two bodies by inner distances, which do not change where limbs swing, and a little by position, in which the
/// body counts more than the limbs [PCS16], [VCFTC19]: from far apart to near, turning the one onto the other at each
/// step. The bodies' coordinates must be turned onto each other, roughly. No poses, and infinite distortion, where a
/// body has no points.
BodyCoupling coupleBodies(const BodyGraph& a, const BodyGraph& b);

}  // namespace slicemorph

#pragma once

#include "engine/match/body_graph.h"

namespace slicemorph {

/// A body bent onto another one.
struct ElasticFit : BodyPose {
  bool hopeless = false;  ///< given up before the end; then the figures below are not set
  double strain = 0;      ///< root mean square of the edges' relative change beyond rotation
  double residual = 0;  ///< mean distance of either surface's samples from the other, in sizes of the target
  /// Share of both surfaces' samples around which one surface has much more area than the other, as where a
  /// part has no partner or two have the same.
  double missed = 0;
};

/// Points that a body graph carries along.
struct BoundPoints {
  std::vector<Vec3d> own;                   ///< where they are on the body itself
  std::vector<BodyGraph::Binding> binding;  ///< per point
};

BoundPoints bindPoints(const BodyGraph& graph, const std::vector<Vec3d>& points);

/// Where bound points are, their nodes being at `position` and turned by `rotation`.
std::vector<Vec3d> carried(const BodyGraph& graph, const BoundPoints& points,
                           const std::vector<Vec3d>& position, const std::vector<Mat3d>& rotation);

/// Bends a body onto another surface as rigidly as possible: edges keep their lengths and directions but for the
/// rotations of their ends [SA07], neighbouring rotations differ little [LG15], and surface points are drawn to
/// the planes of the nearest points that look the same way, from either surface to the other [CM92]; stiff at
/// first, then softer. Sliding along the surface costs nothing, so that only what keeps its shape decides where
/// along a limb a point goes. `start`: where the nodes are at first and how they are turned; their own where the body lies
/// on the other already.
/// `surface`, `target`: samples of both surfaces, in the same coordinates. `hopeless`: the residual beyond which the fit
/// is given up while the body is still stiff.
ElasticFit fitElastically(const BodyGraph& graph, const OrientedPoints& surface, const OrientedPoints& target,
                          const BodyPose& start, double hopeless);

/// The body part of the way to a fit of it, at `t` from 0 to 1: rotations and stretches are blended apart, node by node,
/// and joined by one least-squares solution [XZWB05]; a body that is crumpled rather than turned goes straight. The same
/// from the other side but for such a one. Its figures are not set.
ElasticFit partWay(const BodyGraph& graph, const ElasticFit& fit, double t);

/// By how much parts are turned against the whole, radians: all but 2 % of the nodes by no more.
double largestTurn(const BodyGraph& graph, const ElasticFit& fit);

}  // namespace slicemorph

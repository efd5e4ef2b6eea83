#pragma once

#include "engine/blend/moving_lattice.h"

namespace slicemorph {

/// How the objects' distances are weighted.
struct DistanceBlend {
  LocalWeights weights;
  std::vector<double> sizes;  ///< per object: mean scale of its chart; each distance is divided by it
  /// Mean scale of the in-between's chart, by which the sum is multiplied. Where weights vary in space the
  /// local weighted mean of `sizes` is used instead.
  double size = 1;
};

/// Level set of the in-between, sum_k w_k F_k(M_k(p)), computed leaf by leaf in the narrow band only: the map
/// is interpolated by splines between the nodes, the objects' distances are sampled and blended in units of
/// each object's own size, and the result is redistanced. Objects whose weight is 0 everywhere are not
/// sampled. The result does not depend on the thread count.
FloatGrid::Ptr rebuildLevelSet(const NodeMap& nodes, const Fields& fields, const DistanceBlend& blend,
                               const openvdb::math::Transform& transform);

}  // namespace slicemorph

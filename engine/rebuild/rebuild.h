#pragma once

#include "engine/blend/moving_lattice.h"

namespace slicemorph {

/// What the distances of the objects count.
struct DistanceBlend {
  LocalWeights weights;
  std::vector<double> sizes;  ///< per object: its chart's size; distances count in units of these
  double size =
      1;  ///< of the in-between's chart, where weights do not vary; else it is the sizes' local mean
};

/// Level set of the in-between sum_k w_k F_k(M_k(p)) in the narrow band only, leaf by leaf: the map is
/// splined between the nodes, the objects' distances are sampled and blended in units of each object's own
/// size, and the result is made a distance again. Objects that count nowhere are not sampled. The same for
/// any thread count.
FloatGrid::Ptr rebuildLevelSet(const NodeMap& nodes, const Fields& fields, const DistanceBlend& blend,
                               const openvdb::math::Transform& transform);

}  // namespace slicemorph

#pragma once

#include "engine/blend/moving_lattice.h"

namespace slicemorph {

/// Level set of the in-between sum_k w_k F_k(M_k(p)) in the narrow band only, leaf by leaf: the map is splined between
/// the nodes, the objects' distances are sampled and blended in units of each object's own size, and the result is
/// made a distance again. `scale`: world units per chart unit of the in-between. The same for any thread count.
FloatGrid::Ptr rebuildLevelSet(const NodeMap& nodes, const Fields& fields, const std::vector<Chart>& charts,
                               const Weights& weights, double scale, const openvdb::math::Transform& transform);

}  // namespace slicemorph

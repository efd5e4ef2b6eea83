#pragma once

#include "engine/blend/moving_lattice.h"

namespace slicemorph {

/// Level set of the in-between sum_k w_k F_k(M_k(p)) in the narrow band only, leaf by leaf: the map is splined between
/// the nodes, the objects' distances are sampled and blended in units of each object's own size, and the result is
/// made a distance again. `factors`: of each object's distances in the sum, its weight times the in-between's size over
/// the object's own; objects of factor 0 are not sampled. The same for any thread count.
FloatGrid::Ptr rebuildLevelSet(const NodeMap& nodes, const Fields& fields, const std::vector<double>& factors,
                               const openvdb::math::Transform& transform);

}  // namespace slicemorph

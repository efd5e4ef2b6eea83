#include "engine/blend/node_stretch.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {

NodeStretch::NodeStretch(const NodeMap& nodes, size_t object, const Mat3d& voxelPerWorld)
    : nodes_(nodes), local_(nodes.known.size()) {
  tbb::parallel_for(0, int(nodes.size[2]), [&](int z) {
    for (int y = 0; y < nodes.size[1]; ++y)
      for (int x = 0; x < nodes.size[0]; ++x) {
        const openvdb::Coord c = nodes.origin + openvdb::Coord(x, y, z);
        const Mat3d stretch = jacobian(c[0], c[1], c[2], object) * voxelPerWorld;
        local_[nodes.index(c[0], c[1], c[2])] = {openvdb::Mat3s(polarRotation(stretch)),
                                                 float(std::max(stretch.det(), 0.0))};
      }
  });
}

/// Derivative of the position on the object by the in-between's voxels: central differences, one-sided ones
/// next to unknown nodes.
Mat3d NodeStretch::jacobian(int i, int j, int k, size_t object) const {
  Mat3d result = Mat3d::zero();
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Coord low(i, j, k), high(i, j, k);
    const auto known = [&](const openvdb::Coord& c) {
      return nodes_.inside(c[0], c[1], c[2]) && nodes_.known[nodes_.index(c[0], c[1], c[2])];
    };
    --low[axis], ++high[axis];
    if (!known(low)) ++low[axis];
    if (!known(high)) --high[axis];
    const int span = (high[axis] - low[axis]) * nodes_.step;
    if (span == 0) continue;
    const auto position = [&](const openvdb::Coord& c) {
      return nodes_.at[nodes_.index(c[0], c[1], c[2]) * nodes_.objects + object];
    };
    const Vec3d d = Vec3d(position(high) - position(low)) / span;
    for (int row = 0; row < 3; ++row) result(row, axis) = d[row];
  }
  return result;
}

NodeStretch::Local NodeStretch::at(int i, int j, int k, const openvdb::Vec3s& fraction) const {
  Local sum{openvdb::Mat3s::zero(), 0};
  for (int n = 0; n < 8; ++n) {
    const float w = (n & 1 ? fraction[0] : 1 - fraction[0]) * (n & 2 ? fraction[1] : 1 - fraction[1]) *
                    (n & 4 ? fraction[2] : 1 - fraction[2]);
    if (w == 0) continue;
    const Local& local = local_[nodes_.index(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2))];
    sum.rotation += local.rotation * w;
    sum.volume += local.volume * w;
  }
  return sum;
}

/// Newton's iteration for the orthogonal polar factor.
Mat3d polarRotation(Mat3d m) {
  if (!(m.det() > 0)) return Mat3d::identity();
  for (int i = 0; i < 12; ++i) m = (m + m.inverse().transpose()) * 0.5;
  return m;
}

}  // namespace slicemorph

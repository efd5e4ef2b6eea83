#include "engine/rebuild/image_nodes.h"

#include "engine/volume/image_grid.h"

#include <cmath>

namespace slicemorph {

using openvdb::Vec3s;

ImageNodes imageNodes(const ImageLattice& on, const Carrying& carrying, double spacing) {
  ImageNodes nodes;
  ImageLattice coarse = on;
  openvdb::Coord last;
  for (int d = 0; d < 3; ++d) {
    nodes.step[d] = std::max(1, int(std::lround(spacing / on.spacing()[d])));
    coarse.step[d] = double(nodes.step[d]) * on.step[d];
    last[d] = (on.size[d] - 1) / nodes.step[d] + 1;
  }
  nodes.map = carryingNodes({openvdb::Coord(0), last}, carrying, *transformOf(coarse), 1);
  return nodes;
}

PositionRow::PositionRow(const ImageNodes& nodes, size_t shape)
    : nodes_(nodes), shape_(shape), node_(size_t(nodes.map.size[0])) {}

void PositionRow::begin(int first, int last, int j, int k) {
  const NodeMap& map = nodes_.map;
  const openvdb::Vec3i& s = nodes_.step;
  const int y = j / s[1], z = k / s[2];
  const float fy = float(j - y * s[1]) / float(s[1]), fz = float(k - z * s[2]) / float(s[2]);
  const auto at = [&](int i, int dy, int dz) -> const Vec3s& {
    return map.at[map.index(i, y + dy, z + dz) * map.objects + shape_];
  };
  for (int i = first / s[0]; i <= last / s[0] + 1; ++i) {
    const Vec3s low = at(i, 0, 0) * (1 - fy) + at(i, 1, 0) * fy;
    const Vec3s high = at(i, 0, 1) * (1 - fy) + at(i, 1, 1) * fy;
    node_[size_t(i)] = low * (1 - fz) + high * fz;
  }
}

PositionRow::Stretch PositionRow::from(int i) const {
  const int across = nodes_.step[0], node = i / across, offset = i - node * across;
  const Vec3s step = (node_[size_t(node) + 1] - node_[size_t(node)]) / float(across);
  return {node_[size_t(node)] + step * float(offset), step, across - offset};
}

PositionToVoxel::PositionToVoxel(const ImageLattice& lattice, const Vec3d& anchor) {
  const WorldToVoxel voxel(lattice);
  turn_ = voxel.inverse;
  offset_ = voxel(anchor);
}

Vec3s PositionToVoxel::operator()(const Vec3s& position) const {
  return Vec3s(turn_ * Vec3d(position) + offset_);
}

}  // namespace slicemorph

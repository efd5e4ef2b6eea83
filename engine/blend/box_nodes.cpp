#include "engine/blend/box_nodes.h"

#include "engine/blend/find_nodes.h"

#include <algorithm>

namespace slicemorph {

NodeMap boxNodes(const openvdb::CoordBBox& box, const Lattice& lattice, const LatticePose& pose,
                 const openvdb::math::Transform& transform, int step, const NodeFields& fields) {
  NodeMap map;
  map.step = step;
  map.origin = openvdb::Coord::floor(box.min().asVec3d() / step) - openvdb::Coord(1);
  map.size = openvdb::Coord::ceil(box.max().asVec3d() / step) + openvdb::Coord(2) - map.origin;
  PosedLattice posed = posedLattice(lattice, pose, fields.onLattice, transform, step);
  std::fill(posed.near.begin(), posed.near.end(), 1);
  findNodes(posed, map);
  forUnknownNodes(map, pose.chart, transform, [&](const Vec3d& q, size_t n) {
    for (size_t f = 0; f < map.objects; ++f) map.at[n * map.objects + f] = fields.beyond(q, f);
    map.known[n] = 1;
  });
  return map;
}

openvdb::BBoxd boxOnPose(const LatticeOnObjects& on, size_t object, const openvdb::BBoxd& world,
                         const LatticePose& pose, const openvdb::math::Transform& transform) {
  openvdb::BBoxd box;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at(world.min()[0] + (corner & 1) * world.extents()[0],
                   world.min()[1] + (corner >> 1 & 1) * world.extents()[1],
                   world.min()[2] + (corner >> 2) * world.extents()[2]);
    box.expand(transform.worldToIndex(pose.chart.toWorld(on.charts[object].toChart(at))));
  }
  // Include nodes up to a cell outside: the space between nodes reaches as far.
  const Vec3d cell(on.lattice.spacing * on.charts[object].meanScale());
  const openvdb::BBoxd wide(world.min() - cell, world.max() + cell);
  for (size_t i = 0; i < on.lattice.count(); ++i)
    if (wide.isInside(on.anchor[object] + Vec3d(on.position[object][i])))
      box.expand(transform.worldToIndex(pose.world[i]));
  return box;
}

}  // namespace slicemorph

#pragma once

#include "engine/rebuild/warp_grid.h"
#include "slicemorph/image.h"

namespace slicemorph {

/// Map nodes on a dense image lattice: every step[d]-th voxel along axis d is a node.
struct ImageNodes {
  openvdb::Vec3i step{1, 1, 1};
  NodeMap map;  ///< on the nodes' own index space, in which neighbouring nodes are 1 apart
};

/// Nodes over the lattice `on`, about `spacing` (world units) apart along each axis. `spacing` is that of the
/// matching's lattice: the map holds no finer detail.
ImageNodes imageNodes(const ImageLattice& on, const Carrying& carrying, double spacing);

/// Positions on one object along a row of the in-between's voxels, interpolated linearly between the nodes.
/// In world units, relative to the anchor of the object's distance field.
class PositionRow {
 public:
  /// `nodes` must outlive this.
  PositionRow(const ImageNodes& nodes, size_t shape);

  /// Selects the voxels (first .. last, j, k).
  void begin(int first, int last, int j, int k);

  /// The run of voxels that starts at voxel i of the selected row and ends before the next node: consecutive
  /// positions there differ by the constant `step`.
  struct Stretch {
    openvdb::Vec3s at, step;
    int length;
  };
  Stretch from(int i) const;

 private:
  const ImageNodes& nodes_;
  size_t shape_;
  std::vector<openvdb::Vec3s> node_;  ///< position at each node of the row
};

/// Converts positions (world units, relative to an anchor) to voxel coordinates of an image.
class PositionToVoxel {
 public:
  PositionToVoxel(const ImageLattice& lattice, const Vec3d& anchor);
  openvdb::Vec3s operator()(const openvdb::Vec3s& position) const;
  /// Converts a vector, without the translation.
  openvdb::Vec3s vector(const openvdb::Vec3s& world) const { return openvdb::Vec3s(turn_ * Vec3d(world)); }

 private:
  Mat3d turn_;
  Vec3d offset_;
};

}  // namespace slicemorph

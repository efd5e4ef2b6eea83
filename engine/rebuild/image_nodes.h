#pragma once

#include "engine/rebuild/warp_grid.h"
#include "slicemorph/image.h"

namespace slicemorph {

/// Nodes that carry a dense lattice: every step[d]-th voxel along axis d.
struct ImageNodes {
  openvdb::Vec3i step{1, 1, 1};
  NodeMap map;  ///< index space: that of the nodes, steps apart
};

/// About as fine as the matching's lattice: no more can be told.
ImageNodes imageNodes(const ImageLattice& on, const Carrying& carrying, double spacing);

/// Places of one object's material along rows of the in-between's voxels, linear between the nodes; world
/// units relative to the anchor of the object's field.
class PositionRow {
 public:
  /// `nodes` must outlive this.
  PositionRow(const ImageNodes& nodes, size_t shape);

  /// Goes to the row of voxels (first .. last, j, k).
  void begin(int first, int last, int j, int k);

  /// From voxel i of the row on, as long as one step leads from position to position.
  struct Stretch {
    openvdb::Vec3s at, step;
    int length;
  };
  Stretch from(int i) const;

 private:
  const ImageNodes& nodes_;
  size_t shape_;
  std::vector<openvdb::Vec3s> node_;  ///< along the row
};

/// Places relative to an anchor as voxels of an image.
class PositionToVoxel {
 public:
  PositionToVoxel(const ImageLattice& lattice, const Vec3d& anchor);
  openvdb::Vec3s operator()(const openvdb::Vec3s& position) const;
  /// A way instead of a position.
  openvdb::Vec3s vector(const openvdb::Vec3s& world) const { return openvdb::Vec3s(turn_ * Vec3d(world)); }

 private:
  Mat3d turn_;
  Vec3d offset_;
};

}  // namespace slicemorph

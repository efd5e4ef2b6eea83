#pragma once

#include "slicemorph/mesh.h"

namespace slicemorph {

/// A closed surface of rings of points between two tips, as parallels of latitude lie between the poles. All surfaces of
/// the same numbers have their points in the same order: first tip, ring after ring, last tip.
struct RingLayout {
  int rings = 0;  ///< 1 or more, the tips not counted
  int around =
      0;  ///< points of a ring, 3 or more; seen along the direction from first to last tip they run clockwise

  size_t count() const { return size_t(rings) * size_t(around) + 2; }
  size_t index(int ring, int at) const { return 1 + size_t(ring) * size_t(around) + size_t(at); }
  /// Of a point on a sphere, where rings are parallels of latitude at equal steps from pole to pole along z: unit vector.
  Vec3d direction(size_t point) const;
  /// The triangles between the points, wound outwards.
  std::vector<openvdb::Vec3I> triangles() const;
};

/// Level set named "surface" of a closed surface; without any inside where the surface encloses no voxel. Where the
/// surface passes through itself, all that cannot be reached from outside is inside. Throws InputError as voxelise for
/// absurd sizes.
FloatGrid::Ptr levelSetOfMesh(const Mesh& mesh, double voxelSize);

}  // namespace slicemorph

#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// An image as a grid whose index space is the image's voxels: float (double for doubles and 32-bit
/// integers), labels int32. The commonest value is the background, everything else active. What a grid cannot
/// tell (extent, number type) is kept as metadata "image_size", "image_type", so that imageOf gives the image
/// back.
openvdb::GridBase::Ptr gridOf(const Image& image, const std::string& name, bool labels);

/// A scalar grid as an image: the one it was made of by gridOf, else its active voxels' box, as float, double
/// or int32. Throws InputError where the grid's transform is not linear, it is empty, or it holds no numbers.
Image imageOf(const openvdb::GridBase& grid);

/// Index space of a lattice.
openvdb::math::Transform::Ptr transformOf(const ImageLattice& lattice);

/// Voxel coordinates of a world point.
struct WorldToVoxel {
  explicit WorldToVoxel(const ImageLattice& lattice);
  Vec3d operator()(const Vec3d& world) const { return inverse * (world - origin); }
  Mat3d inverse;
  Vec3d origin;
};

}  // namespace slicemorph

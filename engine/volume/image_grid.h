#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// An image as a grid whose index space is the image's voxels: float (double for double and 32-bit integer
/// images), int32 for labels. The most frequent value on the image's faces is the background; all other
/// voxels are active. What a grid cannot hold (extent, number type) is kept as metadata "image_size",
/// "image_type", so that imageOf restores the image.
openvdb::GridBase::Ptr gridOf(const Image& image, const std::string& name, bool labels);

/// A scalar grid as an image: the original one if gridOf made the grid, else the box of its active voxels as
/// float, double or int32. Throws InputError if the grid's transform is not linear, it is empty, or it holds
/// no numbers.
Image imageOf(const openvdb::GridBase& grid);

/// The transform whose index space is the lattice's voxels.
openvdb::math::Transform::Ptr transformOf(const ImageLattice& lattice);

/// Converts a world point to voxel coordinates.
struct WorldToVoxel {
  explicit WorldToVoxel(const ImageLattice& lattice);
  Vec3d operator()(const Vec3d& world) const { return inverse * (world - origin); }
  Mat3d inverse;
  Vec3d origin;
};

}  // namespace slicemorph

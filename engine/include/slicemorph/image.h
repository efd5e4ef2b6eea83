#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>
#include <variant>

namespace slicemorph {

/// Positions of a dense image's voxels: the centre of voxel (i, j, k) is origin + i step[0] + j step[1]
/// + k step[2].
struct ImageLattice {
  openvdb::Coord size{0, 0, 0};  ///< voxels along i (fastest in memory), j, k
  Vec3d origin{0, 0, 0};         ///< world (LPS millimetres): centre of voxel (0, 0, 0)
  /// World vectors from a voxel to the next one along i, j, k: direction times spacing.
  Vec3d step[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  size_t count() const { return size_t(size[0]) * size[1] * size[2]; }
  size_t index(int i, int j, int k) const { return (size_t(k) * size[1] + j) * size[0] + i; }
  Vec3d toWorld(const Vec3d& v) const { return origin + v[0] * step[0] + v[1] * step[1] + v[2] * step[2]; }
  Vec3d spacing() const { return {step[0].length(), step[1].length(), step[2].length()}; }
};

using ImageValues =
    std::variant<std::vector<std::uint8_t>, std::vector<std::int16_t>, std::vector<std::uint16_t>,
                 std::vector<std::int32_t>, std::vector<float>, std::vector<double>>;

/// A dense image as scanners and label editors write it: one value per voxel, in the file's own number type
/// (after rescaling).
struct Image {
  ImageLattice lattice;
  ImageValues values;  ///< lattice.count() of them
};

}  // namespace slicemorph

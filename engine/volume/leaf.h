#pragma once

#include <cstddef>

namespace slicemorph {

/// Side length of OpenVDB's leaves in voxels, and their number of voxels.
constexpr int kLeaf = 8, kLeafSize = kLeaf * kLeaf * kLeaf;

/// Offset of voxel (x, y, z) of a leaf, each 0 to 7, in the leaf's buffer.
constexpr size_t leafOffset(int x, int y, int z) { return size_t((x * kLeaf + y) * kLeaf + z); }

}  // namespace slicemorph

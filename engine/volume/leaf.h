#pragma once

#include <cstddef>

namespace slicemorph {

/// Side of OpenVDB's leaves in voxels, and how many voxels they have.
constexpr int kLeaf = 8, kLeafSize = kLeaf * kLeaf * kLeaf;

/// Where a leaf's voxel (x, y, z), each 0 to 7, stands in its buffer.
constexpr size_t leafOffset(int x, int y, int z) { return size_t((x * kLeaf + y) * kLeaf + z); }

}  // namespace slicemorph

#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// The nodes of a regular lattice, equally spaced along the three axes of its space (world space, chart
/// space, ...). The value of node (x, y, z) is at index(x, y, z) of an array, x fastest.
struct Lattice {
  Vec3d origin{0, 0, 0};  ///< position of node (0, 0, 0)
  double spacing = 1;     ///< distance between nodes
  openvdb::Coord size{1, 1, 1};

  size_t count() const { return size_t(size[0]) * size[1] * size[2]; }
  size_t index(int x, int y, int z) const { return (size_t(z) * size[1] + y) * size[0] + x; }
  size_t index(const openvdb::Coord& c) const { return index(c[0], c[1], c[2]); }
  /// Corner `c` (bits x, y, z) of the cell whose first node is (x, y, z).
  size_t corner(int x, int y, int z, int c) const {
    return index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
  }
  openvdb::Coord coordOf(size_t index) const {
    return {int(index % size[0]), int(index / size[0] % size[1]), int(index / size[0] / size[1])};
  }
  bool holds(const openvdb::Coord& c) const {
    return c[0] >= 0 && c[1] >= 0 && c[2] >= 0 && c[0] < size[0] && c[1] < size[1] && c[2] < size[2];
  }
  Vec3d position(int x, int y, int z) const { return origin + spacing * Vec3d(x, y, z); }
  Vec3d position(const openvdb::Coord& c) const { return position(c[0], c[1], c[2]); }
  /// A lattice with this spacing that covers `box` and is centred on it.
  static Lattice over(const openvdb::BBoxd& box, double spacing);
};

}  // namespace slicemorph

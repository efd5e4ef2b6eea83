#pragma once

#include "engine/numerics/lattice.h"

#include <array>
#include <cstdint>

namespace slicemorph {

/// A point in a cell of a lattice: a trilinear value there is the sum of the corners' values by weight().
struct CellPoint {
  std::uint32_t cell = 0;     ///< its first node
  float u = 0, v = 0, w = 0;  ///< how far between the nodes, 0 to 1

  /// `corner`: bits x, y, z.
  float weight(int corner) const {
    return (corner & 1 ? u : 1 - u) * (corner & 2 ? v : 1 - v) * (corner & 4 ? w : 1 - w);
  }
};

/// Points outside the lattice are moved onto its border.
CellPoint cellPoint(const Lattice& lattice, const Vec3d& p);

/// From a cell's first node to each of its corners.
std::array<std::uint32_t, 8> cornerOffsets(const Lattice& lattice);

/// Trilinear value of one value a node.
double valueAt(const Lattice& lattice, const std::vector<float>& values, const CellPoint& point);

/// Its gradient, per unit of the lattice's space.
Vec3d gradientAt(const Lattice& lattice, const std::vector<float>& values, const CellPoint& point);

}  // namespace slicemorph

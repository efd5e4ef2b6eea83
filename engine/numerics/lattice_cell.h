#pragma once

#include "engine/numerics/lattice.h"

#include <array>
#include <cstdint>

namespace slicemorph {

/// A point in a cell of a lattice. A trilinear value there is the sum of the corners' values times weight().
struct CellPoint {
  std::uint32_t cell = 0;     ///< index of its first node
  float u = 0, v = 0, w = 0;  ///< position within the cell, 0 to 1 along x, y, z

  /// `corner`: bit a is set for the far corner along axis a.
  float weight(int corner) const {
    return (corner & 1 ? u : 1 - u) * (corner & 2 ? v : 1 - v) * (corner & 4 ? w : 1 - w);
  }
};

/// The cell that contains a point. Points outside the lattice are clamped to its border.
CellPoint cellPoint(const Lattice& lattice, const Vec3d& p);

/// Index offsets from a cell's first node to its corners.
std::array<std::uint32_t, 8> cornerOffsets(const Lattice& lattice);

/// Trilinear value of an array with one value per node.
double valueAt(const Lattice& lattice, const std::vector<float>& values, const CellPoint& point);

/// Gradient of the same, per unit of the lattice's space.
Vec3d gradientAt(const Lattice& lattice, const std::vector<float>& values, const CellPoint& point);

}  // namespace slicemorph

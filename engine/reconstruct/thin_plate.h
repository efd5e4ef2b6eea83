#pragma once

#include "slicemorph/conventions.h"

#include <array>
#include <cstdint>

namespace slicemorph {

/// Nodes of a box of space, i fastest; the axes are the world's.
struct NodeBox {
  openvdb::Coord size{0, 0, 0};
  Vec3d origin{0, 0, 0};  ///< world: node (0, 0, 0)
  double step = 1;        ///< world units between nodes

  size_t count() const { return size_t(size[0]) * size[1] * size[2]; }
  size_t index(int i, int j, int k) const { return (size_t(k) * size[1] + j) * size[0] + i; }
  openvdb::Coord coordOf(size_t n) const {
    return {int(n % size[0]), int(n / size[0] % size[1]), int(n / size[0] / size[1])};
  }
  Vec3d place(const openvdb::Coord& c) const { return origin + step * c.asVec3d(); }
};

/// A place in a cell of a NodeBox: the trilinear value there is the sum of the corners' values by weight().
struct CellPlace {
  std::uint32_t cell = 0;  ///< its first node
  float u = 0, v = 0, w = 0;

  float weight(int corner) const {
    return (corner & 1 ? u : 1 - u) * (corner & 2 ? v : 1 - v) * (corner & 4 ? w : 1 - w);
  }
};

/// Places outside the box are moved onto its border.
CellPlace cellPlace(const NodeBox& box, const Vec3d& world);
std::array<std::uint32_t, 8> cornerOffsets(const NodeBox& box);
double valueAt(const NodeBox& box, const std::vector<float>& values, const CellPlace& place);
/// World units per world unit, from the cell's corners.
Vec3d gradientAt(const NodeBox& box, const std::vector<float>& values, const CellPlace& place);

/// "The function has this value here", as strongly as `weight` says against the bending of a node's
/// surroundings.
struct PlateDatum {
  CellPlace place;
  float target = 0, weight = 1;
};

struct PlateSettings {
  int iterations = 60;
  double tolerance = 1e-3;  ///< of the residual, against the first one
};

/// Minimises the bending energy (sum of all squared second differences) plus the data's squared residuals
/// over the `active` nodes (ascending; none within two nodes of the box's border), all others held: conjugate
/// gradients with the diagonal as preconditioner. `values` is the first guess. Returns the steps taken.
int solvePlate(const NodeBox& box, const std::vector<std::uint32_t>& active,
               const std::vector<PlateDatum>& data, const PlateSettings& settings,
               std::vector<float>& values);

}  // namespace slicemorph

#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>

namespace slicemorph {

/// Where a node lies in the matching's lattice: in a tetrahedron [Kuh60] of one of its cells.
struct LatticePlace {
  static constexpr std::uint32_t kBeyond = ~std::uint32_t(0);
  std::uint32_t cell = kBeyond;   ///< index of the cell's first node; kBeyond: in no cell
  std::uint32_t tetrahedron = 0;  ///< of kKuhnTetrahedra
  double share[3] = {0, 0, 0};    ///< barycentric coordinates of the tetrahedron's second to fourth corner
};

/// Vectors at the nodes of a coarse grid over a frame's voxels. For the backward map of an in-between: the
/// position of each node on every object. Nodes far from the in-between's surface may be unknown.
struct NodeMap {
  int step = 4;                    ///< voxels between nodes; node (i, j, k) is voxel step * (i, j, k)
  openvdb::Coord origin{0, 0, 0};  ///< first node
  openvdb::Coord size{0, 0, 0};
  size_t objects = 0;
  std::vector<openvdb::Vec3s>
      at;  ///< per node and object: a position in the world is relative to the field's anchor
  std::vector<char> known;          ///< per node
  std::vector<LatticePlace> place;  ///< per node; empty for maps without a lattice
  std::vector<double> jump;  ///< per object, world units: neighbours further apart lie on crossing slices
  double foldShare = 0;      ///< share of the surface's cells whose Jacobian to some object is below 0.05

  size_t index(int i, int j, int k) const {
    return (size_t(k - origin[2]) * size[1] + (j - origin[1])) * size[0] + (i - origin[0]);
  }
  bool inside(int i, int j, int k) const {
    return i >= origin[0] && j >= origin[1] && k >= origin[2] && i < origin[0] + size[0] &&
           j < origin[1] + size[1] && k < origin[2] + size[2];
  }
};

}  // namespace slicemorph

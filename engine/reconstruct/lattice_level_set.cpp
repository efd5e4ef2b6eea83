#include "engine/reconstruct/lattice_level_set.h"

#include "engine/rebuild/redistance.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace slicemorph {

namespace {

using openvdb::Coord;

/// Leaves with values below this many voxels are kept: twice the band, because values are distances only up
/// to a factor.
constexpr double kNearVoxels = 2 * kHalfWidth;

/// Next to a sign change the surface is near, whatever the values are. They may be large where a detail that
/// the coarser levels missed meets values left from those.
std::vector<float> limitedAtSurface(const Lattice& lattice, std::vector<float> values) {
  const float most = float(2 * lattice.spacing);
  const std::ptrdiff_t toNext[3] = {1, lattice.size[0], std::ptrdiff_t(lattice.size[0]) * lattice.size[1]};
  std::vector<std::vector<size_t>> large(lattice.size[2]);
  tbb::parallel_for(1, lattice.size[2] - 1, [&](int k) {
    for (int j = 1; j < lattice.size[1] - 1; ++j)
      for (size_t n = lattice.index(1, j, k), end = n + lattice.size[0] - 2; n < end; ++n) {
        const float* v = &values[n];
        if (std::abs(*v) <= most) continue;
        for (std::ptrdiff_t s : toNext)
          if ((v[s] < 0) != (*v < 0) || (v[-s] < 0) != (*v < 0)) {
            large[k].push_back(n);
            break;
          }
      }
  });
  for (const std::vector<size_t>& slab : large)
    for (size_t n : slab) values[n] = std::copysign(most, values[n]);
  return values;
}

/// The leaves of a grid, with the lattice's nodes as voxels, that the lattice touches.
class LatticeLeaves {
 public:
  explicit LatticeLeaves(const Lattice& lattice)
      : lattice_(lattice), shift_(Coord::round(lattice.origin / lattice.spacing)) {
    const Coord high = shift_ + lattice.size - Coord(1);
    low_ = shift_ >> 3, size_ = (high >> 3) - low_ + Coord(1);
  }

  size_t count() const { return size_t(size_[0]) * size_[1] * size_[2]; }
  Coord originOf(size_t leaf) const {
    return (low_ +
            Coord(int(leaf % size_[0]), int(leaf / size_[0] % size_[1]), int(leaf / size_[0] / size_[1])))
           << 3;
  }
  /// Calls `action(offset in the leaf, node)` for the leaf's voxels that have a node.
  template <typename Action>
  void forEachNode(const Coord& origin, const Action& action) const {
    for (int x = 0; x < kLeaf; ++x)
      for (int y = 0; y < kLeaf; ++y)
        for (int z = 0; z < kLeaf; ++z) {
          const Coord c = origin - shift_ + Coord(x, y, z);
          if (lattice_.holds(c)) action(leafOffset(x, y, z), lattice_.index(c));
        }
  }

 private:
  const Lattice& lattice_;
  /// First node in voxels; first leaf and number of leaves per axis, in leaves.
  Coord shift_, low_, size_;
};

}  // namespace

FloatGrid::Ptr latticeLevelSet(const Lattice& lattice, std::vector<float> function) {
  const std::vector<float> values = limitedAtSurface(lattice, std::move(function));
  const LatticeLeaves leaves(lattice);
  const float near = float(kNearVoxels * lattice.spacing);
  std::vector<char> wanted(leaves.count(), 0);
  tbb::parallel_for(size_t(0), wanted.size(), [&](size_t b) {
    leaves.forEachNode(leaves.originOf(b),
                       [&](size_t, size_t n) { wanted[b] |= std::abs(values[n]) < near; });
  });
  std::vector<Coord> origins;
  for (size_t b = 0; b < wanted.size(); ++b)
    if (wanted[b]) origins.push_back(leaves.originOf(b));
  SparseValues sparse(origins, float(lattice.spacing));
  tbb::parallel_for(size_t(0), origins.size(), [&](size_t i) {
    leaves.forEachNode(origins[i], [&](size_t voxel, size_t n) { sparse.leaf(i)[voxel] = values[n]; });
  });
  return redistance(sparse, *openvdb::math::Transform::createLinearTransform(lattice.spacing));
}

}  // namespace slicemorph

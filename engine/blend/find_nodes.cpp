#include "engine/blend/find_nodes.h"

#include "engine/numerics/lattice_cell.h"
#include "engine/numerics/tetrahedra.h"

#include <algorithm>
#include <array>
#include <utility>

namespace slicemorph {

namespace {

/// Tolerance of barycentric coordinates, so that a point on a shared face is found in at
/// least one tetrahedron.
constexpr double kOnFace = 1e-6;

}  // namespace

/// Finds the nodes inside the tetrahedra of one slab's cells.
class PosedLattice::SlabNodes {
 public:
  std::vector<size_t> node;
  std::vector<float> distance;  ///< blended, chart units
  std::vector<LatticePlace> place;

  void find(const PosedLattice& posed, const NodeMap& map, int z) {
    const Lattice& lattice = posed.lattice_;
    for (int y = 0; y + 1 < lattice.size[1]; ++y)
      for (int x = 0; x + 1 < lattice.size[0]; ++x)
        if (posed.near_[lattice.index(x, y, z)]) findInCell(posed, map, {x, y, z});
  }

 private:
  void findInCell(const PosedLattice& posed, const NodeMap& map, const openvdb::Coord& first) {
    size_t corner[8];
    Vec3d p[8], cellLow(1e30), cellHigh(-1e30);
    for (int c = 0; c < 8; ++c) {
      corner[c] = posed.lattice_.corner(first[0], first[1], first[2], c);
      p[c] = posed.node_[corner[c]];
      for (int a = 0; a < 3; ++a)
        cellLow[a] = std::min(cellLow[a], p[c][a]), cellHigh[a] = std::max(cellHigh[a], p[c][a]);
    }
    openvdb::Coord low = openvdb::Coord::ceil(cellLow - Vec3d(kOnFace));
    openvdb::Coord high = openvdb::Coord::floor(cellHigh + Vec3d(kOnFace));
    low.maxComponent(map.origin);
    high.minComponent(map.origin + map.size - openvdb::Coord(1));
    if (low[0] > high[0] || low[1] > high[1] || low[2] > high[2]) return;
    const std::vector<float>& f = posed.pose_.distance;
    for (int tetrahedron = 0; tetrahedron < 6; ++tetrahedron) {
      const auto& t = kKuhnTetrahedra[tetrahedron];
      const Vec3d e1 = p[t[1]] - p[t[0]], e2 = p[t[2]] - p[t[0]], e3 = p[t[3]] - p[t[0]];
      const double volume = e1.cross(e2).dot(e3);
      if (!(posed.handed_ * volume > 0)) continue;
      const Vec3d n1 = e2.cross(e3) / volume, n2 = e3.cross(e1) / volume, n3 = e1.cross(e2) / volume;
      for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
          for (int i = low[0]; i <= high[0]; ++i) {
            const Vec3d d = Vec3d(i, j, k) - p[t[0]];
            const double b1 = n1.dot(d), b2 = n2.dot(d), b3 = n3.dot(d), b0 = 1 - b1 - b2 - b3;
            if (b0 < -kOnFace || b1 < -kOnFace || b2 < -kOnFace || b3 < -kOnFace) continue;
            node.push_back(map.index(i, j, k));
            distance.push_back(float(b0 * f[corner[t[0]]] + b1 * f[corner[t[1]]] + b2 * f[corner[t[2]]] +
                                     b3 * f[corner[t[3]]]));
            place.push_back({std::uint32_t(corner[0]), std::uint32_t(tetrahedron), {b1, b2, b3}});
          }
    }
  }
};

PosedLattice::PosedLattice(const Lattice& lattice, const LatticePose& pose,
                           const openvdb::math::Transform& transform, int step, std::vector<char> near)
    : lattice_(lattice), pose_(pose), near_(std::move(near)), node_(new Vec3d[lattice.count()]) {
  handed_ = transform.baseMap()->getAffineMap()->getMat4().det() < 0 ? -1 : 1;
  std::vector<openvdb::BBoxd> boxes(size_t(lattice.size[2]));
  tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
    // The nodes of this layer that cells below or above have.
    const size_t layer = lattice.index(0, 0, z);
    std::vector<char> used(size_t(lattice.size[0]) * lattice.size[1], 0);
    for (int below = std::max(z - 1, 0); below <= z; ++below)
      for (int y = 0; y + 1 < lattice.size[1]; ++y)
        for (int x = 0; x + 1 < lattice.size[0]; ++x)
          if (near_[lattice.index(x, y, below)])
            for (int c = 0; c < 4; ++c) used[lattice.corner(x, y, z, c) - layer] = 1;
    for (size_t i = 0; i < used.size(); ++i)
      if (used[i]) boxes[size_t(z)].expand(node_[layer + i] = inNodes(pose, layer + i, transform, step));
  });
  for (const openvdb::BBoxd& box : boxes) box_.expand(box);
}

void PosedLattice::place(NodeMap& map) const {
  const size_t nodes = size_t(map.size[0]) * map.size[1] * map.size[2];
  map.place.assign(nodes, {});
  map.known.assign(nodes, 0);
  std::vector<SlabNodes> found(size_t(lattice_.size[2]));
  tbb::parallel_for(0, int(lattice_.size[2]) - 1, [&](int z) { found[size_t(z)].find(*this, map, z); });
  std::vector<float> nearest(nodes, kNothingThere);
  for (const SlabNodes& f : found)
    for (size_t i = 0; i < f.node.size(); ++i) {
      const size_t n = f.node[i];
      if (!(f.distance[i] < nearest[n])) continue;
      nearest[n] = f.distance[i];
      map.known[n] = 1, map.place[n] = f.place[i];
    }
}

void evaluateAtPlaces(const Lattice& lattice, const std::vector<const VectorField*>& fields, NodeMap& map) {
  map.objects = fields.size();
  map.at.resize(map.place.size() * fields.size());
  const std::array<std::uint32_t, 8> offset = cornerOffsets(lattice);
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, map.place.size()), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t n = range.begin(); n < range.end(); ++n) {
          const LatticePlace& place = map.place[n];
          if (!map.known[n] || place.cell == LatticePlace::kBeyond) continue;
          const auto& t = kKuhnTetrahedra[place.tetrahedron];
          const double b1 = place.share[0], b2 = place.share[1], b3 = place.share[2], b0 = 1 - b1 - b2 - b3;
          for (size_t f = 0; f < fields.size(); ++f) {
            const openvdb::Vec3s* a = &(*fields[f])[place.cell];
            map.at[n * fields.size() + f] =
                openvdb::Vec3s(b0 * Vec3d(a[offset[t[0]]]) + b1 * Vec3d(a[offset[t[1]]]) +
                               b2 * Vec3d(a[offset[t[2]]]) + b3 * Vec3d(a[offset[t[3]]]));
          }
        }
      });
}

}  // namespace slicemorph

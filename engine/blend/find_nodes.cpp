#include "engine/blend/find_nodes.h"

#include "engine/numerics/tetrahedra.h"

#include <algorithm>

namespace slicemorph {

namespace {

/// Tolerance of barycentric coordinates, so that a point on a shared face is found in at
/// least one tetrahedron.
constexpr double kOnFace = 1e-6;

/// Finds the nodes inside the near tetrahedra of one slab, and interpolates the fields there.
class SlabNodes {
 public:
  std::vector<size_t> node;
  std::vector<float> distance;     ///< blended, chart units
  std::vector<openvdb::Vec3s> at;  ///< per node and field

  void find(const PosedLattice& posed, const NodeMap& map, int z) {
    const Lattice& lattice = posed.lattice;
    for (int y = 0; y + 1 < lattice.size[1]; ++y)
      for (int x = 0; x + 1 < lattice.size[0]; ++x)
        if (posed.near[lattice.index(x, y, z)]) findInCell(posed, map, {x, y, z});
  }

 private:
  void findInCell(const PosedLattice& posed, const NodeMap& map, const openvdb::Coord& first) {
    size_t corner[8];
    Vec3d p[8], cellLow(1e30), cellHigh(-1e30);
    for (int c = 0; c < 8; ++c) {
      corner[c] = posed.lattice.corner(first[0], first[1], first[2], c);
      p[c] = posed.node[corner[c]];
      for (int a = 0; a < 3; ++a)
        cellLow[a] = std::min(cellLow[a], p[c][a]), cellHigh[a] = std::max(cellHigh[a], p[c][a]);
    }
    openvdb::Coord low = openvdb::Coord::ceil(cellLow - Vec3d(kOnFace));
    openvdb::Coord high = openvdb::Coord::floor(cellHigh + Vec3d(kOnFace));
    low.maxComponent(map.origin);
    high.minComponent(map.origin + map.size - openvdb::Coord(1));
    if (low[0] > high[0] || low[1] > high[1] || low[2] > high[2]) return;
    for (const auto& t : kKuhnTetrahedra) {
      const Vec3d e1 = p[t[1]] - p[t[0]], e2 = p[t[2]] - p[t[0]], e3 = p[t[3]] - p[t[0]];
      const double volume = e1.cross(e2).dot(e3);
      if (!(posed.handed * volume > 0)) continue;
      const Vec3d n1 = e2.cross(e3) / volume, n2 = e3.cross(e1) / volume, n3 = e1.cross(e2) / volume;
      const size_t corners[4] = {corner[t[0]], corner[t[1]], corner[t[2]], corner[t[3]]};
      for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
          for (int i = low[0]; i <= high[0]; ++i) {
            const Vec3d d = Vec3d(i, j, k) - p[t[0]];
            const double b1 = n1.dot(d), b2 = n2.dot(d), b3 = n3.dot(d), b0 = 1 - b1 - b2 - b3;
            if (b0 < -kOnFace || b1 < -kOnFace || b2 < -kOnFace || b3 < -kOnFace) continue;
            node.push_back(map.index(i, j, k));
            add(posed, corners, b0, b1, b2, b3);
          }
    }
  }

  /// Appends the interpolated values at a point with these barycentric coordinates.
  void add(const PosedLattice& posed, const size_t (&corner)[4], double b0, double b1, double b2, double b3) {
    const std::vector<float>& f = posed.pose.distance;
    distance.push_back(float(b0 * f[corner[0]] + b1 * f[corner[1]] + b2 * f[corner[2]] + b3 * f[corner[3]]));
    for (const VectorField* field : posed.fields) {
      const VectorField& a = *field;
      at.push_back(openvdb::Vec3s(b0 * Vec3d(a[corner[0]]) + b1 * Vec3d(a[corner[1]]) +
                                  b2 * Vec3d(a[corner[2]]) + b3 * Vec3d(a[corner[3]])));
    }
  }
};

}  // namespace

PosedLattice posedLattice(const Lattice& lattice, const LatticePose& pose,
                          std::vector<const VectorField*> fields, const openvdb::math::Transform& transform,
                          int step) {
  PosedLattice posed{lattice, pose, std::move(fields), std::vector<Vec3d>(lattice.count()),
                     std::vector<char>(lattice.count(), 0)};
  posed.handed = transform.baseMap()->getAffineMap()->getMat4().det() < 0 ? -1 : 1;
  tbb::parallel_for(size_t(0), posed.node.size(),
                    [&](size_t i) { posed.node[i] = transform.worldToIndex(pose.world[i]) / step; });
  return posed;
}

void findNodes(const PosedLattice& posed, NodeMap& map) {
  map.objects = posed.fields.size();
  const size_t nodes = size_t(map.size[0]) * map.size[1] * map.size[2];
  map.at.resize(nodes * map.objects);
  map.known.assign(nodes, 0);
  std::vector<SlabNodes> found(posed.lattice.size[2]);
  tbb::parallel_for(0, int(posed.lattice.size[2]) - 1, [&](int z) { found[z].find(posed, map, z); });
  std::vector<float> nearest(nodes, kNothingThere);
  for (const SlabNodes& f : found)
    for (size_t i = 0; i < f.node.size(); ++i) {
      const size_t n = f.node[i];
      if (!(f.distance[i] < nearest[n])) continue;
      nearest[n] = f.distance[i];
      map.known[n] = 1;
      std::copy_n(&f.at[i * map.objects], map.objects, &map.at[n * map.objects]);
    }
}

}  // namespace slicemorph

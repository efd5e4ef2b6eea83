#include "engine/match/fold_guard.h"

#include "engine/numerics/tetrahedra.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

constexpr int kMaxRounds = 60;

/// A map that must be free of folds: s + own * D_k(s) + all * sum_l D_l(s).
struct Guarded {
  size_t object;
  double own, all;
};

/// Those to every object, and to points on the way there from the middle.
std::vector<Guarded> guardedMaps(size_t objects) {
  std::vector<Guarded> result;
  for (size_t k = 0; k < objects; ++k)
    for (double toward : {1.0, 0.5}) {
      Weights w(objects, (1 - toward) / double(objects));
      w[k] += toward;
      const Weights path = pathWeights(w);
      const double others = objects > 1 ? path[k == 0 ? 1 : 0] : 0;
      result.push_back({k, path[k] - others, others});
    }
  return result;
}

/// A number for each node of a box within a lattice; 0 for all others.
struct Mask {
  openvdb::CoordBBox box;  ///< of node coordinates
  openvdb::Coord size;     ///< of the box
  std::vector<float> share;

  Mask(const openvdb::CoordBBox& nodes, float value)
      : box(nodes), size(nodes.dim()), share(size_t(nodes.volume()), value) {}
  size_t index(int x, int y, int z) const {
    return (size_t(z - box.min()[2]) * size[1] + (y - box.min()[1])) * size[0] + (x - box.min()[0]);
  }
  float at(int x, int y, int z) const {
    return box.isInside(openvdb::Coord(x, y, z)) ? share[index(x, y, z)] : 0;
  }
};

openvdb::CoordBBox allNodes(const Lattice& lattice) { return {openvdb::Coord(0), lattice.size.offsetBy(-1)}; }

/// Calls visit(x, y, z) for the nodes of a box, in slabs of one task each.
template <typename Visit>
void forEachNode(const openvdb::CoordBBox& box, const Visit& visit) {
  tbb::parallel_for(box.min()[2], box.max()[2] + 1, [&](int z) {
    for (int y = box.min()[1]; y <= box.max()[1]; ++y)
      for (int x = box.min()[0]; x <= box.max()[0]; ++x) visit(x, y, z);
  });
}

/// How much of the smoothed field each node takes: 1 within two cells of a fold, falling off over four more.
/// `folded`: the cells' first nodes; not empty.
Mask smoothingMask(const Lattice& lattice, const std::vector<openvdb::Coord>& folded) {
  constexpr int kWider = 3;
  openvdb::CoordBBox box;
  for (const openvdb::Coord& cell : folded) box.expand({cell, cell.offsetBy(1)});
  box.expand(kWider);
  box.intersect(allNodes(lattice));
  Mask mask(box, 0);
  for (const openvdb::Coord& cell : folded)
    for (int c = 0; c < 8; ++c)
      mask.share[mask.index(cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2))] = 1;
  const int step[3] = {1, mask.size[0], mask.size[0] * mask.size[1]};
  for (int round = 0; round < kWider; ++round)
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<float> old = mask.share;
      forEachNode(box, [&](int x, int y, int z) {
        const int c = openvdb::Coord(x, y, z)[axis];
        const size_t i = mask.index(x, y, z);
        if (c > box.min()[axis]) mask.share[i] = std::max(mask.share[i], 0.8f * old[i - step[axis]]);
        if (c < box.max()[axis]) mask.share[i] = std::max(mask.share[i], 0.8f * old[i + step[axis]]);
      });
    }
  return mask;
}

/// One step towards the mean of the six neighbours (zero beyond the lattice), where the mask says so.
void smooth(const Lattice& lattice, VectorField& field, const Mask& mask) {
  VectorField smoothed(mask.share.size());
  const int step[3] = {1, lattice.size[0], lattice.size[0] * lattice.size[1]};
  forEachNode(mask.box, [&](int x, int y, int z) {
    const size_t i = lattice.index(x, y, z), own = mask.index(x, y, z);
    if (mask.share[own] == 0) return;
    const openvdb::Coord c(x, y, z);
    openvdb::Vec3s sum(0.f);
    for (int axis = 0; axis < 3; ++axis) {
      if (c[axis] > 0) sum += field[i - step[axis]];
      if (c[axis] + 1 < lattice.size[axis]) sum += field[i + step[axis]];
    }
    smoothed[own] = field[i] + (sum / 6.f - field[i]) * mask.share[own];
  });
  forEachNode(mask.box, [&](int x, int y, int z) {
    const size_t own = mask.index(x, y, z);
    if (mask.share[own] != 0) field[lattice.index(x, y, z)] = smoothed[own];
  });
}

/// Brings `sum`, the sum of all objects' displacements at every node, up to date in a box.
void addUp(const Displacements& map, const openvdb::CoordBBox& box, VectorField& sum) {
  forEachNode(box, [&](int x, int y, int z) {
    const size_t i = map.lattice.index(x, y, z);
    sum[i] = map.of[0][i];
    for (size_t k = 1; k < map.of.size(); ++k) sum[i] += map.of[k][i];
  });
}

/// Smallest volume of a cell's tetrahedra after a map, over their volume before.
double smallestRatio(const Displacements& map, const VectorField& sum, const Guarded& guarded, int x, int y,
                     int z) {
  const Lattice& lattice = map.lattice;
  Vec3d p[8];
  for (int c = 0; c < 8; ++c) {
    const int dx = c & 1, dy = c >> 1 & 1, dz = c >> 2;
    const size_t i = lattice.index(x + dx, y + dy, z + dz);
    p[c] = lattice.spacing * Vec3d(dx, dy, dz) + guarded.own * Vec3d(map.of[guarded.object][i]) +
           guarded.all * Vec3d(sum[i]);
  }
  double smallest = 1e30;
  for (const auto& t : kKuhnTetrahedra) smallest = std::min(smallest, parallelepipedVolume(p, t));
  return smallest / (lattice.spacing * lattice.spacing * lattice.spacing);
}

/// The longest difference of a field's values at the ends of a cell's four edges along each axis.
openvdb::Vec3s longestDifferences(const VectorField& field, const size_t (&corner)[8]) {
  openvdb::Vec3s longest(0.f);
  for (int axis = 0; axis < 3; ++axis) {
    for (int from = 0; from < 8; ++from)
      if (!(from & 1 << axis))
        longest[axis] =
            std::max(longest[axis], (field[corner[from | 1 << axis]] - field[corner[from]]).lengthSqr());
    longest[axis] = std::sqrt(longest[axis]);
  }
  return longest;
}

/// How long the vector of those differences may be, in spacings, for a map that surely squeezes no tetrahedron below
/// `floor`. A Kuhn tetrahedron has an edge along each axis, so the differences are the columns of the displacement's
/// gradient G; det(I + G) >= (1 - |G|)^3, and |G| is no more than the root of the columns' squares. Rounding takes
/// far less than the thousandth that is kept back.
double harmlessDifference(double floor) { return 0.999 * (1 - std::cbrt(floor)); }

/// Cells with a suspect corner that some guarded map squeezes below the floor, by their first nodes.
std::vector<openvdb::Coord> foldedCells(const Displacements& map, const VectorField& sum,
                                        const std::vector<Guarded>& guarded, double floor,
                                        const Mask& suspect) {
  const Lattice& lattice = map.lattice;
  const double harmless = harmlessDifference(floor) * lattice.spacing;
  openvdb::CoordBBox cells(suspect.box.min().offsetBy(-1), suspect.box.max());
  cells.intersect({openvdb::Coord(0), lattice.size.offsetBy(-2)});
  if (cells.empty()) return {};
  // Two objects' displacements are mostly each other's opposites: what holds of the one holds of the other.
  const bool balanced =
      std::all_of(sum.begin(), sum.end(), [](const openvdb::Vec3s& d) { return d == openvdb::Vec3s(0.f); });
  const bool alike = balanced && map.of.size() == 2;
  std::vector<std::vector<openvdb::Coord>> slabs(size_t(cells.dim()[2]));
  forEachNode(cells, [&](int x, int y, int z) {
    size_t corner[8];
    bool any = false;
    for (int c = 0; c < 8; ++c) {
      corner[c] = lattice.corner(x, y, z, c);
      any |= suspect.at(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)) > 0;
    }
    if (!any) return;
    bool folds = false;
    const openvdb::Vec3s ofSum = balanced ? openvdb::Vec3s(0.f) : longestDifferences(sum, corner);
    openvdb::Vec3s ofOwn(0.f);
    for (size_t w = 0; w < guarded.size() && !folds; ++w) {
      const Guarded& g = guarded[w];
      if (w == 0 || (g.object != guarded[w - 1].object && !alike))
        ofOwn = longestDifferences(map.of[g.object], corner);
      const Vec3d most = std::abs(g.own) * Vec3d(ofOwn) + std::abs(g.all) * Vec3d(ofSum);
      if (most.lengthSqr() <= harmless * harmless) continue;
      folds = smallestRatio(map, sum, g, x, y, z) < floor;
    }
    if (folds) slabs[size_t(z - cells.min()[2])].emplace_back(x, y, z);
  });
  std::vector<openvdb::Coord> folded;
  for (const auto& slab : slabs) folded.insert(folded.end(), slab.begin(), slab.end());
  return folded;
}

}  // namespace

double leastRatio(const Displacements& map) {
  std::vector<double> least(map.lattice.size[2], 1e30);
  for (size_t k = 0; k < map.of.size(); ++k)
    forEachNode({openvdb::Coord(0), map.lattice.size.offsetBy(-2)}, [&](int x, int y, int z) {
      least[z] = std::min(least[z], smallestRatio(map, map.of[k], {k, 1, 0}, x, y, z));
    });
  return *std::min_element(least.begin(), least.end());
}

int removeFolds(Displacements& map, double floor) {
  const std::vector<Guarded> guarded = guardedMaps(map.of.size());
  Mask suspect(allNodes(map.lattice), 1);
  VectorField sum(map.lattice.count());
  addUp(map, suspect.box, sum);
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<openvdb::Coord> folded = foldedCells(map, sum, guarded, floor, suspect);
    if (folded.empty()) return round;
    // Only what is moved can fold anew.
    suspect = smoothingMask(map.lattice, folded);
    for (int i = 0; i < 2 + round / 8; ++i)
      for (VectorField& field : map.of) smooth(map.lattice, field, suspect);
    addUp(map, suspect.box, sum);
  }
  // What smoothing cannot cure shrinks towards the middle space, which has no folds.
  for (VectorField& field : map.of)
    for (auto& d : field) d *= 0.7f;
  return kMaxRounds + removeFolds(map, floor);
}

}  // namespace slicemorph

#include "engine/match/fold_guard.h"

#include "engine/numerics/tetrahedra.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

constexpr int kMaxRounds = 60;

/// Calls visit(x, y, z) for all cells, in slabs of one task each.
template <typename Visit>
void forEachCell(const Lattice& lattice, const Visit& visit) {
  tbb::parallel_for(0, int(lattice.size[2]) - 1, [&](int z) {
    for (int y = 0; y + 1 < lattice.size[1]; ++y)
      for (int x = 0; x + 1 < lattice.size[0]; ++x) visit(x, y, z);
  });
}

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

/// How much of the smoothed field each node takes: 1 within two cells of a fold, falling off over four more.
std::vector<float> smoothingMask(const Lattice& lattice, const std::vector<char>& folded) {
  std::vector<float> mask(lattice.count(), 0.f);
  for (int z = 0; z + 1 < lattice.size[2]; ++z)
    for (int y = 0; y + 1 < lattice.size[1]; ++y)
      for (int x = 0; x + 1 < lattice.size[0]; ++x)
        if (folded[lattice.index(x, y, z)])
          for (int c = 0; c < 8; ++c) mask[lattice.corner(x, y, z, c)] = 1.f;
  const int step[3] = {1, lattice.size[0], lattice.size[0] * lattice.size[1]};
  for (int round = 0; round < 3; ++round)
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<float> wider = mask;
      for (int z = 0; z < lattice.size[2]; ++z)
        for (int y = 0; y < lattice.size[1]; ++y)
          for (int x = 0; x < lattice.size[0]; ++x) {
            const openvdb::Coord c(x, y, z);
            const size_t i = lattice.index(x, y, z);
            if (c[axis] > 0) wider[i] = std::max(wider[i], 0.8f * mask[i - step[axis]]);
            if (c[axis] + 1 < lattice.size[axis]) wider[i] = std::max(wider[i], 0.8f * mask[i + step[axis]]);
          }
      mask.swap(wider);
    }
  return mask;
}

/// One step towards the mean of the six neighbours (zero beyond the lattice), where the mask says so.
void smooth(const Lattice& lattice, VectorField& field, const std::vector<float>& mask) {
  const VectorField old = field;
  const int step[3] = {1, lattice.size[0], lattice.size[0] * lattice.size[1]};
  tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const size_t i = lattice.index(x, y, z);
        if (mask[i] == 0) continue;
        const openvdb::Coord c(x, y, z);
        openvdb::Vec3s sum(0.f);
        for (int axis = 0; axis < 3; ++axis) {
          if (c[axis] > 0) sum += old[i - step[axis]];
          if (c[axis] + 1 < lattice.size[axis]) sum += old[i + step[axis]];
        }
        field[i] = old[i] + (sum / 6.f - old[i]) * mask[i];
      }
  });
}

/// Sum of all objects' displacements at every node.
VectorField sumOf(const Displacements& map) {
  VectorField sum = map.of[0];
  for (size_t k = 1; k < map.of.size(); ++k)
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += map.of[k][i];
  return sum;
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

/// Cells with a suspect corner that some guarded map squeezes below the floor.
std::vector<char> foldedCells(const Displacements& map, const std::vector<Guarded>& guarded, double floor,
                              const std::vector<char>& suspect) {
  const Lattice& lattice = map.lattice;
  const VectorField sum = sumOf(map);
  const double harmless = harmlessDifference(floor) * lattice.spacing;
  std::vector<char> folded(lattice.count(), 0);
  forEachCell(lattice, [&](int x, int y, int z) {
    size_t corner[8];
    bool any = false;
    for (int c = 0; c < 8; ++c) corner[c] = lattice.corner(x, y, z, c), any |= suspect[corner[c]] != 0;
    if (!any) return;
    char& result = folded[corner[0]];
    const openvdb::Vec3s ofSum = longestDifferences(sum, corner);
    openvdb::Vec3s ofOwn(0.f);
    for (size_t w = 0; w < guarded.size() && !result; ++w) {
      const Guarded& g = guarded[w];
      if (w == 0 || g.object != guarded[w - 1].object) ofOwn = longestDifferences(map.of[g.object], corner);
      const Vec3d most = std::abs(g.own) * Vec3d(ofOwn) + std::abs(g.all) * Vec3d(ofSum);
      if (most.lengthSqr() <= harmless * harmless) continue;
      result = smallestRatio(map, sum, g, x, y, z) < floor;
    }
  });
  return folded;
}

}  // namespace

double leastRatio(const Displacements& map) {
  std::vector<double> least(map.lattice.size[2], 1e30);
  for (size_t k = 0; k < map.of.size(); ++k)
    forEachCell(map.lattice, [&](int x, int y, int z) {
      least[z] = std::min(least[z], smallestRatio(map, map.of[k], {k, 1, 0}, x, y, z));
    });
  return *std::min_element(least.begin(), least.end());
}

int removeFolds(Displacements& map, double floor) {
  const std::vector<Guarded> guarded = guardedMaps(map.of.size());
  std::vector<char> suspect(map.lattice.count(), 1);
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<char> folded = foldedCells(map, guarded, floor, suspect);
    if (std::find(folded.begin(), folded.end(), 1) == folded.end()) return round;
    const std::vector<float> mask = smoothingMask(map.lattice, folded);
    for (int i = 0; i < 2 + round / 8; ++i)
      for (VectorField& field : map.of) smooth(map.lattice, field, mask);
    // Only what was moved can fold anew.
    for (size_t i = 0; i < suspect.size(); ++i) suspect[i] = mask[i] > 0;
  }
  // What smoothing cannot cure shrinks towards the middle space, which has no folds.
  for (VectorField& field : map.of)
    for (auto& d : field) d *= 0.7f;
  return kMaxRounds + removeFolds(map, floor);
}

}  // namespace slicemorph

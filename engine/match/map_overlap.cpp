#include "engine/match/map_overlap.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Calls `action(s, inside)` for the nodes of the lattice on which overlaps are summed, slab by slab in parallel: how far
/// each object is inside there, 0 to 1, in ascending order.
template <typename Action>
void forInsides(const MatchObjects& objects, const Displacements& map, const Lattice& lattice,
                const Action& action) {
  const size_t count = objects.count();
  const Fields& fields = objects.shape.fields;
  const std::vector<Chart>& charts = objects.charts;
  std::vector<double> unit;
  unit.reserve(count);
  for (const Chart& chart : charts) unit.push_back(1 / (chart.meanScale() * lattice.spacing));
  std::vector<DistanceField::Sampler> samplers;
  for (size_t k = 0; k < count; ++k) samplers.emplace_back(*fields[k]);
  std::vector<std::vector<double>> insides(lattice.size[2], std::vector<double>(count));
  tbb::parallel_for(0, int(lattice.size[2]), [&](int iz) {
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const Vec3d s = lattice.position(x, y, iz);
        std::vector<double>& inside = insides[size_t(iz)];
        for (size_t k = 0; k < count; ++k) {
          const Vec3d z = s + map.at(k, s);
          const double d = samplers[k].coarse(fields[k]->relative(charts[k].toWorld(z))) * unit[k];
          inside[k] = charts[k].spread(z) > 0 ? std::min(std::max(0.5 - d, 0.0), 1.0) : 0;
        }
        std::sort(inside.begin(), inside.end());
        action(size_t(iz), s, inside);
      }
  });
}

/// Sums of min and max over all pairs of objects.
struct Shared {
  double both = 0, either = 0;
  /// The n-th smallest is the minimum of its pairs with the larger ones.
  void add(const std::vector<double>& inside) {
    const size_t count = inside.size();
    for (size_t n = 0; n < count; ++n)
      both += inside[n] * double(count - 1 - n), either += inside[n] * double(n);
  }
  double overlap() const { return either > 0 ? both / either : 0; }
};

}  // namespace

double mapOverlap(const MatchObjects& objects, const Displacements& map) {
  const Lattice lattice = objects.lattice(objects.overlapSpacing);
  std::vector<Shared> slabs(lattice.size[2]);
  forInsides(objects, map, lattice,
             [&](size_t slab, const Vec3d&, const std::vector<double>& inside) { slabs[slab].add(inside); });
  Shared sum;
  for (const Shared& slab : slabs) sum.both += slab.both, sum.either += slab.either;
  return sum.overlap();
}

std::vector<double> overlapsAround(const MatchObjects& objects, const Displacements& map,
                                   const std::vector<std::vector<Vec3d>>& lines, double reach) {
  const Lattice lattice = objects.lattice(objects.overlapSpacing);
  std::vector<std::vector<Shared>> slabs(lattice.size[2], std::vector<Shared>(lines.size()));
  forInsides(objects, map, lattice, [&](size_t slab, const Vec3d& s, const std::vector<double>& inside) {
    if (inside.back() == 0) return;
    double least = reach * reach;
    size_t nearest = lines.size();
    for (size_t i = 0; i < lines.size(); ++i)
      for (const Vec3d& point : lines[i]) {
        const double square = (point - s).lengthSqr();
        if (square < least) least = square, nearest = i;
      }
    if (nearest < lines.size()) slabs[slab][nearest].add(inside);
  });
  std::vector<double> overlaps;
  for (size_t i = 0; i < lines.size(); ++i) {
    Shared sum;
    for (const std::vector<Shared>& slab : slabs) sum.both += slab[i].both, sum.either += slab[i].either;
    overlaps.push_back(sum.overlap());
  }
  return overlaps;
}

double mapStrain(const MatchObjects& objects, const Displacements& map) {
  const size_t objectCount = objects.count();
  const Lattice& lattice = map.lattice;
  const size_t step[3] = {1, size_t(lattice.size[0]), size_t(lattice.size[0]) * lattice.size[1]};
  std::vector<double> sum(lattice.size[2], 0), count(lattice.size[2], 0);
  tbb::parallel_for(1, int(lattice.size[2]) - 1, [&](int z) {
    for (int y = 1; y + 1 < lattice.size[1]; ++y)
      for (int x = 1; x + 1 < lattice.size[0]; ++x) {
        const size_t i = lattice.index(x, y, z);
        const Vec3d s = lattice.position(x, y, z);
        bool any = false;
        for (size_t k = 0; k < objectCount && !any; ++k)
          any = objects.shape.fields[k]->coarse(objects.charts[k].toWorld(s + Vec3d(map.of[k][i]))) < 0;
        if (!any) continue;
        double squares = 0;
        for (const VectorField& field : map.of)
          for (size_t d : step)
            squares += ((field[i + d] - field[i - d]) / (2 * lattice.spacing)).lengthSqr();
        sum[z] += squares / double(objectCount), count[z] += 1;
      }
  });
  double total = 0, n = 0;
  for (size_t z = 0; z < sum.size(); ++z) total += sum[z], n += count[z];
  return n > 0 ? std::sqrt(total / n) : 0;
}

}  // namespace slicemorph

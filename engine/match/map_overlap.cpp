#include "engine/match/map_overlap.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

double mapOverlap(const MatchObjects& objects, const Displacements& map) {
  const size_t count = objects.count();
  const Fields& fields = objects.shape.fields;
  const std::vector<Chart>& charts = objects.charts;
  const Lattice lattice = objects.lattice(objects.overlapSpacing);
  std::vector<double> both(lattice.size[2], 0), either(lattice.size[2], 0);
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
        // Sums of min and max over all pairs: the n-th smallest is the minimum of its pairs
        // with the larger ones.
        std::sort(inside.begin(), inside.end());
        for (size_t n = 0; n < count; ++n)
          both[size_t(iz)] += inside[n] * double(count - 1 - n), either[size_t(iz)] += inside[n] * double(n);
      }
  });
  double sumBoth = 0, sumEither = 0;
  for (size_t z = 0; z < both.size(); ++z) sumBoth += both[z], sumEither += either[z];
  return sumEither > 0 ? sumBoth / sumEither : 0;
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

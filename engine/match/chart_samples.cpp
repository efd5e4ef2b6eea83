#include "engine/match/chart_samples.h"

#include <cmath>
#include <map>

namespace slicemorph {

ChartSamples chartSamples(const DistanceField& field, const Chart& chart) {
  ChartSamples result;
  OrientedPoints& points = result.points;
  double total = 0;
  for (const SurfaceSample& s : field.samples()) {
    const Vec3d z = chart.toChart(s.position);
    points.position.push_back(z);
    points.normal.push_back(chart.normalToChart(z, s.normal));
    points.mass.push_back(s.area);
    total += s.area;
  }
  for (double& m : points.mass) m /= total;
  result.area = total / (chart.meanScale() * chart.meanScale());
  return result;
}

OrientedPoints thinned(const ChartSamples& samples, int count, const Vec3d& origin) {
  const OrientedPoints& all = samples.points;
  if (int(all.position.size()) <= count) return all;
  // The factor 1.3 (by hand) allows for the bins that an oblique surface only cuts a corner of: it crosses
  // more bins than its area divided by theirs.
  const double cell = 1.3 * std::sqrt(samples.area / count);
  std::map<SurfaceBin, size_t> bins;
  OrientedPoints result;
  for (size_t i = 0; i < all.position.size(); ++i) {
    const Vec3d& n = all.normal[i];
    const SurfaceBin bin = surfaceBin(all.position[i], n, origin, cell);
    const auto [it, fresh] = bins.emplace(bin, result.position.size());
    if (fresh) {
      result.position.push_back(all.position[i]), result.normal.push_back(n),
          result.mass.push_back(all.mass[i]);
      continue;
    }
    // A bin is represented by the sample nearest its cube's centre: a mean would not lie on the surface.
    const Vec3d middle = origin + cell * (Vec3d(bin[2], bin[1], bin[0]) + Vec3d(0.5));
    const size_t at = it->second;
    if ((all.position[i] - middle).lengthSqr() < (result.position[at] - middle).lengthSqr())
      result.position[at] = all.position[i], result.normal[at] = n;
    result.mass[at] += all.mass[i];
  }
  return result;
}

}  // namespace slicemorph

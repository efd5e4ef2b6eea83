#include "engine/blend/lay_along_spine.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {

namespace {

/// Number of slabs along the spine; chosen by hand, a little finer than Bend::kStations.
constexpr int kSlabs = 160;

/// A pose cut across the spine into slabs of equal thickness, each with its own weights.
struct SpineSlabs {
  double low = 0, step = 1;      ///< chart units
  std::vector<Weights> weights;  ///< per slab: mean over its nodes inside
  Weights mean;                  ///< over all nodes inside

  int slabOf(double z0) const { return std::min(std::max(int((z0 - low) / step), 0), kSlabs - 1); }
};

/// Divides the sums in `slab` by the counts in `inside`; slabs with nothing inside take the
/// nearest one's weights.
void fillEmptySlabs(const std::vector<double>& inside, std::vector<Weights>& slab) {
  int last = -1;
  for (int s = 0; s < kSlabs; ++s) {
    if (inside[size_t(s)] == 0) continue;
    for (double& w : slab[size_t(s)]) w /= inside[size_t(s)];
    const int middle = last < 0 ? 0 : (last + s + 1) / 2;
    for (int n = last + 1; n < s; ++n) slab[size_t(n)] = n < middle ? slab[size_t(last)] : slab[size_t(s)];
    last = s;
  }
  for (int n = last + 1; n < kSlabs && last >= 0; ++n) slab[size_t(n)] = slab[size_t(last)];
}

SpineSlabs slabsOf(const LatticePose& pose, const NodeWeights& local, size_t objects) {
  double low = 1e300, high = -1e300;
  for (const Vec3d& q : pose.at) low = std::min(low, q[0]), high = std::max(high, q[0]);
  SpineSlabs slabs{low, (high - low) / kSlabs, std::vector<Weights>(kSlabs, Weights(objects, 0)),
                   Weights(objects, 0)};
  std::vector<double> inside(kSlabs, 0);
  const bool any = *std::min_element(pose.distance.begin(), pose.distance.end()) <= 0;
  for (size_t i = 0; i < pose.at.size(); ++i) {
    if (any && pose.distance[i] > 0) continue;
    const size_t s = size_t(slabs.slabOf(pose.at[i][0]));
    for (size_t k = 0; k < objects; ++k) slabs.weights[s][k] += double(local[i * objects + k]);
    ++inside[s];
  }
  double all = 0;
  for (const Weights& slab : slabs.weights)
    for (size_t k = 0; k < objects; ++k) slabs.mean[k] += slab[k], all += slab[k];
  for (double& w : slabs.mean) w /= all;
  fillEmptySlabs(inside, slabs.weights);
  return slabs;
}

/// Arc length of the spine from the first slab on; a slab's length is scaled by its weights'
/// mean spine scale.
class SpineLength {
 public:
  SpineLength(const SpineSlabs& slabs, const std::vector<Chart>& charts)
      : slabs_(slabs), length_(kSlabs + 1, 0) {
    for (size_t s = 0; s < kSlabs; ++s) {
      double scale = 0;
      for (size_t k = 0; k < charts.size(); ++k) scale += slabs.weights[s][k] * charts[k].scale[0];
      length_[s + 1] = length_[s] + slabs.step * scale;
    }
  }

  /// Length up to a chart coordinate, world units.
  double at(double z0) const {
    const int s = slabs_.slabOf(z0);
    return length_[size_t(s)] +
           (length_[size_t(s) + 1] - length_[size_t(s)]) * ((z0 - slabs_.low) / slabs_.step - s);
  }

  /// The position on the spine at a length.
  struct Station {
    size_t slab;
    double z0;       ///< chart coordinate
    double stretch;  ///< world units per chart unit
  };
  Station stationAt(double length) const {
    const auto above = std::upper_bound(length_.begin(), length_.end(), length);
    const int s = std::min(std::max(int(above - length_.begin()) - 1, 0), kSlabs - 1);
    const double stretch = (length_[size_t(s) + 1] - length_[size_t(s)]) / slabs_.step;
    return {size_t(s), slabs_.low + s * slabs_.step + (length - length_[size_t(s)]) / stretch, stretch};
  }

 private:
  const SpineSlabs& slabs_;
  std::vector<double> length_;
};

/// Recomputes the chart's turn rates at evenly spaced stations from the objects' rates in the slabs that lie
/// there, scaled by the slabs' stretch. The mean point of the spine stays fixed.
Chart bentBySlabs(Chart chart, const std::vector<Chart>& charts, const SpineSlabs& slabs,
                  const SpineLength& length) {
  const double origin = length.at(0);
  std::vector<Vec3d> rates(Bend::kStations, Vec3d(0.0));
  for (int i = 0; i < Bend::kStations; ++i) {
    const SpineLength::Station at = length.stationAt(chart.bend.stationZ0(i) * chart.scale[0] + origin);
    for (size_t k = 0; k < charts.size(); ++k)
      if (!charts[k].bend.straight())
        rates[size_t(i)] +=
            slabs.weights[at.slab][k] * charts[k].bend.at(at.z0).rate * (chart.scale[0] / at.stretch);
  }
  const Vec3d middle = chart.center + chart.axes * (chart.scale[0] * chart.bend.middle());
  chart.bend = Bend(chart.bend.half(), std::move(rates));
  chart.center = middle - chart.axes * (chart.scale[0] * chart.bend.middle());
  return chart;
}

}  // namespace

LatticePose layAlongSpine(const std::vector<Chart>& charts, const NodeWeights& local, LatticePose pose) {
  const size_t objects = charts.size();
  const SpineSlabs slabs = slabsOf(pose, local, objects);
  const SpineLength length(slabs, charts);
  pose.mean = slabs.mean;
  pose.chart = blendCharts(charts, pose.mean);
  if (!pose.chart.bend.straight()) pose.chart = bentBySlabs(pose.chart, charts, slabs, length);
  const double origin = length.at(0);
  tbb::parallel_for(size_t(0), pose.at.size(), [&](size_t i) {
    Vec3d scale(0.0);
    for (size_t k = 0; k < objects; ++k) scale += double(local[i * objects + k]) * charts[k].scale;
    Vec3d& q = pose.at[i];
    q = Vec3d((length.at(q[0]) - origin) / pose.chart.scale[0], q[1] * scale[1] / pose.chart.scale[1],
              q[2] * scale[2] / pose.chart.scale[2]);
  });
  return pose;
}

}  // namespace slicemorph

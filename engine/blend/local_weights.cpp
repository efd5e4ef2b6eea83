#include "engine/blend/local_weights.h"

#include "engine/numerics/smoothstep.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Width of a border that is not prescribed, as a share of the object's size (diagonal / sqrt
/// 3). Chosen by hand.
constexpr double kBorder = 0.1;

double distanceToBox(const openvdb::BBoxd& box, const Vec3d& p) {
  Vec3d outside(0.0);
  double inside = -1e300;
  for (int a = 0; a < 3; ++a) {
    const double d = std::max(box.min()[a] - p[a], p[a] - box.max()[a]);
    outside[a] = std::max(d, 0.0);
    inside = std::max(inside, d);
  }
  return inside > 0 ? outside.length() : inside;
}

}  // namespace

RegionShares::RegionShares(std::vector<Region> regions, const Fields& fields,
                           const std::vector<Chart>& charts, const std::vector<Chart>& drawn)
    : regions_(std::move(regions)) {
  for (const Region& region : regions_) {
    const DistanceField& field = *fields[region.object];
    const Chart& chart = charts[region.object];
    charts_.push_back(chart);
    drawn_.push_back(drawn[region.object]);
    moved_.push_back(chart.center != drawn_.back().center || chart.axes != drawn_.back().axes ||
                     chart.scale != drawn_.back().scale);
    anchor_.push_back(field.anchor());
    double low = 1e300, high = -1e300;
    for (const SurfaceSample& s : field.samples()) {
      const double along = chart.toChart(s.position)[0] * chart.scale[0];
      low = std::min(low, along), high = std::max(high, along);
    }
    const Vec3d ahead = chart.axes.col(0);
    int lead = 0;
    for (int a = 1; a < 3; ++a)
      if (std::abs(ahead[a]) > std::abs(ahead[lead]) + 1e-9) lead = a;
    spine_.push_back({low, std::max(high - low, 1e-30), ahead[lead] < 0});
    border_.push_back(region.border > 0 ? region.border
                                        : kBorder * field.box().extents().length() / std::sqrt(3.0));
  }
}

double RegionShares::distance(size_t r, const Vec3d& now) const {
  const Region& region = regions_[r];
  const bool back = moved_[r] && region.kind != Region::Kind::kSpine;
  const Vec3d world = back ? drawn_[r].toWorld(charts_[r].toChart(now)) : now;
  switch (region.kind) {
    case Region::Kind::kSphere:
      return (world - region.center).length() - region.radius;
    case Region::Kind::kBox:
      return distanceToBox(region.box, world);
    case Region::Kind::kSpine:
      break;
  }
  // A part of the spine that begins or ends with the object has no boundary there.
  const Spine& spine = spine_[r];
  double along = charts_[r].toChart(world)[0] * charts_[r].scale[0] - spine.low;
  if (spine.reversed) along = spine.length - along;
  double distance = -1e300;
  if (region.from > 0) distance = region.from * spine.length - along;
  if (region.to < 1) distance = std::max(distance, along - region.to * spine.length);
  return distance;
}

bool RegionShares::holdsAnything(size_t r, const DistanceField& field) const {
  const Region& region = regions_[r];
  if (region.kind == Region::Kind::kSpine) return true;
  const bool sphere = region.kind == Region::Kind::kSphere;
  const Vec3d middle = sphere ? region.center : region.box.getCenter();
  if (field.coarse(middle) < (sphere ? region.radius : 0)) return true;
  for (const SurfaceSample& s : field.samples())
    if (distance(r, s.position) < 0) return true;
  return false;
}

float RegionShares::at(size_t r, const openvdb::Vec3s& position) const {
  return float(smoothstep(0.5 - distance(r, anchor_[r] + Vec3d(position)) / border_[r], 0, 1));
}

LocalWeights::LocalWeights(Weights whole, const RegionShares* regions)
    : whole_(std::move(whole)), regions_(regions) {}

std::vector<size_t> LocalWeights::used() const {
  std::vector<char> counts(whole_.size(), 0);
  for (size_t k = 0; k < whole_.size(); ++k) counts[k] = whole_[k] != 0;
  if (vary())
    for (size_t r = 0; r < regions_->count(); ++r) {
      const Region& region = regions_->region(r);
      counts[region.object] = 1;
      for (size_t k = 0; k < whole_.size(); ++k) counts[k] |= region.weights[k] != 0;
    }
  std::vector<size_t> result;
  for (size_t k = 0; k < counts.size(); ++k)
    if (counts[k]) result.push_back(k);
  return result;
}

std::vector<size_t> LocalWeights::regionObjects() const {
  std::vector<size_t> result;
  for (size_t r = 0; vary() && r < regions_->count(); ++r)
    if (const size_t k = regions_->region(r).object;
        std::find(result.begin(), result.end(), k) == result.end())
      result.push_back(k);
  return result;
}

void LocalWeights::blend(const float* shares, double* weights) const {
  std::copy(whole_.begin(), whole_.end(), weights);
  if (!vary()) return;
  for (size_t r = 0; r < regions_->count(); ++r) {
    const Weights& own = regions_->region(r).weights;
    for (size_t k = 0; k < own.size(); ++k) weights[k] += double(shares[r]) * (own[k] - weights[k]);
  }
}

void LocalWeights::find(const openvdb::Vec3s* positions, double* weights) const {
  std::copy(whole_.begin(), whole_.end(), weights);
  if (!vary()) return;
  for (size_t r = 0; r < regions_->count(); ++r) {
    const Region& region = regions_->region(r);
    const double share = double(regions_->at(r, positions[region.object]));
    if (share > 0)
      for (size_t k = 0; k < region.weights.size(); ++k)
        weights[k] += share * (region.weights[k] - weights[k]);
  }
}

}  // namespace slicemorph

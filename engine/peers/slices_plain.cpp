#include "engine/peers/slices_plain.h"

#include "engine/numerics/parallel_each.h"
#include "engine/peers/require.h"
#include "engine/volume/moments.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace slicemorph {
namespace {

constexpr const char* kPlainSlices = "slices-plain";

/// The principal axes' four ways round that keep each axis in its line; the one that turns least from `towards`.
Mat3d nearestWayRound(const Mat3d& axes, const Mat3d& towards) {
  Mat3d best = axes;
  double most = -1e300;
  for (int way = 0; way < 4; ++way) {
    const double sign[3] = {way & 1 ? -1.0 : 1.0, way & 2 ? -1.0 : 1.0,
                            (way & 1) != (way >> 1 & 1) ? -1.0 : 1.0};
    Mat3d turned;
    double trace = 0;
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a) turned(i, a) = sign[a] * axes(i, a), trace += turned(i, a) * towards(i, a);
    if (trace > most + 1e-9) most = trace, best = turned;
  }
  return best;
}

/// Where rays at equal angles from the centroid meet a contour; nothing where one meets it other than once.
std::optional<std::vector<Vec2d>> byRays(const Contour& contour, int count) {
  std::vector<Vec2d> hits;
  for (int s = 0; s < count; ++s) {
    const double angle = 2 * openvdb::math::pi<double>() * s / count;
    const Vec2d d(std::cos(angle), std::sin(angle));
    int found = 0;
    for (size_t i = 0, n = contour.points.size(); i < n; ++i) {
      const Vec2d a = contour.points[i] - contour.centroid,
                  b = contour.points[(i + 1) % n] - contour.centroid;
      const double left = a[0] * d[1] - a[1] * d[0], right = b[0] * d[1] - b[1] * d[0];
      if ((left >= 0) == (right >= 0)) continue;
      const Vec2d at = a + left / (left - right) * (b - a);
      if (at.dot(d) <= 0) continue;
      if (++found > 1) return std::nullopt;
      hits.push_back(contour.centroid + at);
    }
    if (found == 0) return std::nullopt;
  }
  return hits;
}

/// Points at equal steps along a contour, anticlockwise, from the one that lies most nearly at the angle 0.
std::vector<Vec2d> byOrder(const Contour& contour, int count) {
  Contour turned = contour;
  if (contour.hole()) std::reverse(turned.points.begin(), turned.points.end());
  const auto off = [&](const Vec2d& p) {
    const Vec2d d = p - contour.centroid;
    return std::abs(std::atan2(d[1], d[0]));
  };
  const auto first = std::min_element(turned.points.begin(), turned.points.end(),
                                      [&](const Vec2d& a, const Vec2d& b) { return off(a) < off(b); });
  std::rotate(turned.points.begin(), first, turned.points.end());
  return resample(turned, count);
}

/// Matched clouds of points of one group, per object.
std::vector<std::vector<Vec2d>> matchedClouds(const OutlineGroup& group, int count) {
  std::vector<std::vector<Vec2d>> clouds(group.of.size());
  bool rays = true;
  for (size_t k = 0; k < group.of.size() && rays; ++k) {
    if (!group.of[k]) continue;
    const auto hits = byRays(*group.of[k], count);
    rays = hits.has_value();
    if (rays) clouds[k] = *hits;
  }
  for (size_t k = 0; k < group.of.size(); ++k) {
    if (!group.of[k])
      clouds[k].assign(size_t(count), group.centre[k]);
    else if (!rays)
      clouds[k] = byOrder(*group.of[k], count);
  }
  return clouds;
}

}  // namespace

PlainSlices::PlainSlices(const std::vector<Object>& objects, double voxelSize,
                         const PlainSlicesOptions& options)
    : voxelSize_(voxelSize) {
  if (options.slices < 2 || options.samples < 8)
    throw InputError("--method slices-plain: slices is " + std::to_string(options.slices) + " and samples " +
                     std::to_string(options.samples) + "; they must be at least 2 and 8");
  std::vector<OutlineStack> stacks(objects.size());
  Mat3d towards = Mat3d::identity();
  for (size_t k = 0; k < objects.size(); ++k) {
    const DistanceField field(objects[k].levelSet);
    const Moments moments = insideMoments(field);
    Chart chart;
    chart.center = moments.centroid;
    chart.axes = towards = nearestWayRound(principalAxes(moments.covariance).axes, towards);
    stacks[k] = cutOutlines(field, chart, {options.slices, voxelSize, kPlainSlices});
    boxes_.push_back({chart, stacks[k].low, stacks[k].high});
  }
  slices_.resize(size_t(options.slices));
  parallelEach(slices_.size(), [&](size_t i) {
    for (const OutlineGroup& group : groupOutlines(stacks, i))
      slices_[i].push_back(matchedClouds(group, options.samples));
  });
}

FloatGrid::Ptr PlainSlices::frame(const Weights& weights) const {
  requireWeights(weights, boxes_.size());
  LoopStack stack;
  stack.method = kPlainSlices;
  std::vector<Chart> charts;
  for (size_t k = 0; k < boxes_.size(); ++k) {
    charts.push_back(boxes_[k].chart);
    stack.low += weights[k] * boxes_[k].low, stack.high += weights[k] * boxes_[k].high;
  }
  stack.chart = blendCharts(charts, weights);
  stack.slices.resize(slices_.size());
  parallelEach(slices_.size(), [&](size_t i) {
    for (const auto& clouds : slices_[i]) {
      std::vector<Vec2d> loop(clouds[0].size(), Vec2d(0.0));
      for (size_t s = 0; s < loop.size(); ++s)
        for (size_t k = 0; k < clouds.size(); ++k) loop[s] += weights[k] * clouds[k][s];
      stack.slices[i].push_back(std::move(loop));
    }
  });
  return surfaceOfLoops(stack, voxelSize_);
}

}  // namespace slicemorph

#include "engine/peers/contour_average.h"

#include "engine/numerics/parallel_each.h"
#include "engine/peers/require.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

const char* nameOf(ContourAverageKind kind) {
  return kind == ContourAverageKind::kMean     ? "contour-mean"
         : kind == ContourAverageKind::kMedian ? "contour-median"
                                               : "contour-mode";
}

void checkOptions(const ContourAverageOptions& options, const std::string& method) {
  const auto refuse = [&](const char* name, double value, const char* right) {
    throw InputError("--method " + method + ": " + name + " is " + std::to_string(value) + "; it must be " +
                     right);
  };
  if (options.slices < 2) refuse("slices", options.slices, "2 or more");
  if (options.samples < 8) refuse("samples", options.samples, "8 or more");
  if (!(options.width > 0)) refuse("width", options.width, "above 0");
}

/// The world axis along which a box is longest.
Vec3d longestAxis(const openvdb::BBoxd& box) {
  Vec3d axis(0.0);
  axis[int(box.maxExtent())] = 1;
  return axis;
}

/// A chart about a point whose first axis has a given direction; where that is a world axis, so are the others.
Chart chartAcross(const Vec3d& axis, const Vec3d& centre) {
  const Vec3d normal = axis.unit();
  int most = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(normal[a]) > std::abs(normal[most])) most = a;
  Vec3d next(0.0);
  next[(most + 1) % 3] = 1;
  const Vec3d x = (next - next.dot(normal) * normal).unit(), y = normal.cross(x);
  Chart chart;
  chart.center = centre;
  chart.axes = Mat3d(normal[0], x[0], y[0], normal[1], x[1], y[1], normal[2], x[2], y[2]);
  return chart;
}

Vec2d weightedMean(const std::vector<Vec2d>& points, const Weights& weights) {
  Vec2d mean(0.0);
  for (size_t k = 0; k < points.size(); ++k) mean += weights[k] * points[k];
  return mean;
}

Vec2d vectorMedian(const std::vector<Vec2d>& points, const Weights& weights) {
  size_t best = 0;
  double least = 1e300;
  for (size_t k = 0; k < points.size(); ++k) {
    if (!(weights[k] > 0)) continue;
    double sum = 0;
    for (size_t j = 0; j < points.size(); ++j) sum += weights[j] * (points[j] - points[k]).length();
    if (sum < least) least = sum, best = k;
  }
  return points[best];
}

Vec2d modeOf(const std::vector<Vec2d>& points, const Weights& weights, double width) {
  Vec2d best(0.0);
  double most = 0;
  for (size_t k = 0; k < points.size(); ++k) {
    if (!(weights[k] > 0)) continue;
    double near = 0;
    Vec2d sum(0.0);
    for (size_t j = 0; j < points.size(); ++j)
      if ((points[j] - points[k]).length() <= width) near += weights[j], sum += weights[j] * points[j];
    if (near > most) most = near, best = sum / near;
  }
  return best;
}

}  // namespace

Vec2d averageOf(ContourAverageKind kind, const std::vector<Vec2d>& points, const Weights& weights,
                double width) {
  if (kind == ContourAverageKind::kMean) return weightedMean(points, weights);
  const Weights counts = withoutNegatives(weights);
  return kind == ContourAverageKind::kMedian ? vectorMedian(points, counts) : modeOf(points, counts, width);
}

ContourAverage::ContourAverage(const std::vector<Object>& objects, double voxelSize, const Vec3d& axis,
                               const ContourAverageOptions& options)
    : options_(options), voxelSize_(voxelSize), method_(nameOf(options.kind)) {
  checkOptions(options, method_);
  std::vector<std::unique_ptr<DistanceField>> fields(objects.size());
  parallelEach(objects.size(),
               [&](size_t k) { fields[k] = std::make_unique<DistanceField>(objects[k].levelSet); });
  openvdb::BBoxd box;
  for (const auto& field : fields) box.expand(field->box());
  chart_ = chartAcross(axis.length() > 0 ? axis : longestAxis(box), box.getCenter());

  std::vector<OutlineStack> stacks;
  for (const auto& field : fields) {
    stacks.push_back(cutOutlines(*field, chart_, {options.slices, voxelSize, method_}));
    ends_.push_back({stacks.back().low, stacks.back().high});
  }
  slices_.resize(size_t(options.slices));
  parallelEach(slices_.size(), [&](size_t i) {
    for (const OutlineGroup& group : groupOutlines(stacks, i)) {
      Loop loop;
      double radii = 0, count = 0;
      for (size_t k = 0; k < objects.size(); ++k) {
        loop.of.push_back(group.of[k] ? hullSamples(group.of[k]->points, options.samples)
                                      : std::vector<Vec2d>(size_t(options.samples), group.centre[k]));
        if (group.of[k])
          radii += std::sqrt(std::abs(group.of[k]->area) / openvdb::math::pi<double>()), count += 1;
      }
      loop.radius = radii / count;
      slices_[i].push_back(std::move(loop));
    }
  });
}

FloatGrid::Ptr ContourAverage::frame(const Weights& weights) const {
  requireWeights(weights, ends_.size());
  std::vector<Vec2d> ends;
  double length = 0;
  for (const auto& end : ends_)
    ends.emplace_back(end[0], end[1]), length += (end[1] - end[0]) / 2 / double(ends_.size());
  const Vec2d end = averageOf(options_.kind, ends, weights, options_.width * length);
  LoopStack stack{chart_, end[0], end[1], {}, method_};
  stack.slices.resize(slices_.size());
  parallelEach(slices_.size(), [&](size_t i) {
    std::vector<Vec2d> points(ends_.size());
    for (const Loop& loop : slices_[i]) {
      std::vector<Vec2d> averaged;
      for (size_t s = 0; s < loop.of[0].size(); ++s) {
        for (size_t k = 0; k < points.size(); ++k) points[k] = loop.of[k][s];
        averaged.push_back(averageOf(options_.kind, points, weights, options_.width * loop.radius));
      }
      stack.slices[i].push_back(std::move(averaged));
    }
  });
  return surfaceOfLoops(stack, voxelSize_);
}

}  // namespace slicemorph

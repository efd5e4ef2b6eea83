#include "engine/peers/feature_warp.h"

#include "engine/numerics/parallel_each.h"
#include "engine/peers/function_level_set.h"
#include "engine/peers/require.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

using Element = FeatureWarp::Element;

/// The rotation that takes the directions `from` to `to` by the shortest way; both of length 1.
Mat3d shortestTurn(const Vec3d& from, const Vec3d& to) {
  Vec3d axis = from.cross(to);
  if (axis.length() < 1e-12) {  // the same, or opposite: then any way is as short
    axis = from.cross(std::abs(from[0]) < 0.9 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0));
    return from.dot(to) > 0 ? Mat3d::identity()
                            : rotationFromVector(axis.unit() * openvdb::math::pi<double>());
  }
  return rotationFromVector(axis.unit() * std::atan2(axis.length(), from.dot(to)));
}

/// Frames whose first axis points along the given directions: the first one's is the world's, turned by the shortest way,
/// and each further one's is the first one's.
std::vector<Mat3d> framesAlong(const std::vector<Vec3d>& directions) {
  std::vector<Mat3d> frames;
  for (const Vec3d& direction : directions)
    frames.push_back(frames.empty() ? shortestTurn({1, 0, 0}, direction.unit())
                                    : shortestTurn(directions[0].unit(), direction.unit()) * frames[0]);
  return frames;
}

void addPoint(const Feature& feature, std::vector<Element>& elements) {
  Element element{Feature::Kind::kPoint, std::vector<Chart>(feature.positions.size())};
  for (size_t k = 0; k < element.on.size(); ++k) element.on[k].center = feature.positions[k][0];
  elements.push_back(std::move(element));
}

void addDisk(const Feature& feature, std::vector<Element>& elements) {
  Element element{Feature::Kind::kDisk, std::vector<Chart>(feature.positions.size())};
  const std::vector<Mat3d> frames = framesAlong(feature.normals);
  for (size_t k = 0; k < element.on.size(); ++k)
    element.on[k].center = feature.positions[k][0], element.on[k].axes = frames[k],
    element.on[k].scale = Vec3d(feature.radii[k]);
  elements.push_back(std::move(element));
}

/// A line is so many segments.
void addLine(const Feature& feature, std::vector<Element>& elements) {
  for (const auto& positions : feature.positions)
    if (positions.size() != feature.positions[0].size())
      throw InputError("--method feature-warp: feature '" + feature.name + "' has " +
                       std::to_string(feature.positions[0].size()) + " places on one object and " +
                       std::to_string(positions.size()) +
                       " on another; a line needs equally many on all, since segments are matched");
  for (size_t i = 0; i + 1 < feature.positions[0].size(); ++i) {
    Element element{Feature::Kind::kLine, std::vector<Chart>(feature.positions.size())};
    std::vector<Vec3d> directions;
    for (const auto& positions : feature.positions) directions.push_back(positions[i + 1] - positions[i]);
    for (const Vec3d& direction : directions)
      if (!(direction.length() > 0))
        throw InputError("--method feature-warp: feature '" + feature.name +
                         "' has a segment without length");
    const std::vector<Mat3d> frames = framesAlong(directions);
    for (size_t k = 0; k < element.on.size(); ++k) {
      element.on[k].center = 0.5 * (feature.positions[k][i] + feature.positions[k][i + 1]);
      element.on[k].axes = frames[k];
      element.on[k].scale = Vec3d(directions[k].length(), 1, 1);
    }
    elements.push_back(std::move(element));
  }
}

/// Distance of a point of the in-between from an element there, world units. `z`: the point in the element's chart.
double distanceTo(Feature::Kind kind, const Chart& element, const Vec3d& z) {
  Vec3d off = element.scale * z;
  if (kind == Feature::Kind::kLine) off[0] -= std::min(std::max(z[0], -0.5), 0.5) * element.scale[0];
  if (kind != Feature::Kind::kDisk) return off.length();
  return std::hypot(off[0], std::max(std::hypot(off[1], off[2]) - element.scale[1], 0.0));
}

/// The elements of one in-between.
struct WarpAt {
  const std::vector<Element>& elements;
  std::vector<Chart> between;
  double nearness;

  WarpAt(const std::vector<Element>& all, const Weights& weights, double nearness)
      : elements(all), nearness(nearness) {
    for (const Element& element : all) between.push_back(blendCharts(element.on, weights));
  }

  /// Where a point is on the objects; room for one point each in `on`.
  void operator()(const Vec3d& point, std::vector<Vec3d>& on) const {
    std::fill(on.begin(), on.end(), Vec3d(0.0));
    double total = 0;
    for (size_t e = 0; e < elements.size(); ++e) {
      const Vec3d z = between[e].toChart(point);
      const double near = nearness + distanceTo(elements[e].kind, between[e], z);
      const double weight = 1 / (near * near);
      for (size_t k = 0; k < on.size(); ++k) on[k] += weight * elements[e].on[k].toWorld(z);
      total += weight;
    }
    for (Vec3d& p : on) p /= total;
  }
};

/// A box that holds all objects as each element alone would carry them, and a little more: the mean of the maps is none
/// of them.
openvdb::BBoxd boxOf(const WarpAt& warp, const Fields& fields) {
  openvdb::BBoxd box;
  for (size_t e = 0; e < warp.elements.size(); ++e)
    for (size_t k = 0; k < fields.size(); ++k)
      for (int corner = 0; corner < 8; ++corner) {
        Vec3d p;
        for (int a = 0; a < 3; ++a)
          p[a] = corner >> a & 1 ? fields[k]->box().max()[a] : fields[k]->box().min()[a];
        box.expand(warp.between[e].toWorld(warp.elements[e].on[k].toChart(p)));
      }
  const double margin = 0.05 * box.extents().length();
  return {box.min() - Vec3d(margin), box.max() + Vec3d(margin)};
}

}  // namespace

FeatureWarp::FeatureWarp(const std::vector<Object>& objects, double voxelSize,
                         const std::vector<Feature>& features, const FeatureWarpOptions& options)
    : fields_(objects.size()), voxelSize_(voxelSize) {
  if (features.empty())
    throw InputError(
        "--method feature-warp needs features: points, lines or disks that exist on all inputs, "
        "as [[feature]] tables of a job file (`slicemorph pick` makes one) or as landmarks");
  if (!(options.nearness > 0))
    throw InputError("--method feature-warp: nearness is " + std::to_string(options.nearness) +
                     "; it must be above 0");
  for (const Feature& feature : features) {
    if (feature.positions.size() != objects.size())
      throw InputError("feature '" + feature.name + "' has places for " +
                       std::to_string(feature.positions.size()) + " objects; there are " +
                       std::to_string(objects.size()));
    if (feature.kind == Feature::Kind::kPoint) addPoint(feature, elements_);
    if (feature.kind == Feature::Kind::kLine) addLine(feature, elements_);
    if (feature.kind == Feature::Kind::kDisk) addDisk(feature, elements_);
  }
  parallelEach(objects.size(),
               [&](size_t k) { fields_[k] = std::make_shared<DistanceField>(objects[k].levelSet); });
  openvdb::BBoxd box;
  for (const auto& field : fields_) box.expand(field->box());
  nearness_ = options.nearness * box.extents().length();
}

FloatGrid::Ptr FeatureWarp::frame(const Weights& weights) const {
  requireWeights(weights, fields_.size());
  const WarpAt warp(elements_, weights, nearness_);
  const auto makeFunction = [&]() -> PointFunction {
    std::vector<DistanceField::Sampler> samplers;
    for (const auto& field : fields_) samplers.emplace_back(*field);
    return [&, samplers, on = std::vector<Vec3d>(fields_.size())](const Vec3d& p) mutable {
      warp(p, on);
      double sum = 0;
      for (size_t k = 0; k < on.size(); ++k)
        if (weights[k] != 0) sum += weights[k] * double(samplers[k](fields_[k]->relative(on[k])));
      return float(sum);
    };
  };
  return levelSetOfFunction({boxOf(warp, fields_), voxelSize_, "feature-warp"}, makeFunction);
}

Vec3d FeatureWarp::onObject(const Vec3d& point, const Weights& weights, size_t object) const {
  requireWeights(weights, fields_.size());
  std::vector<Vec3d> on(fields_.size());
  WarpAt(elements_, weights, nearness_)(point, on);
  return on[object];
}

}  // namespace slicemorph

#include "engine/follow/ride.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

using openvdb::Coord;

constexpr double kMostStep = 1.0 / 16;

/// The corners of all cells that points lie in.
openvdb::MaskGrid::Ptr cornersAround(const std::vector<Vec3d>& points, double voxelSize) {
  const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  const openvdb::MaskGrid::Ptr cells = openvdb::MaskGrid::create(), corners = openvdb::MaskGrid::create();
  openvdb::MaskGrid::Accessor cell = cells->getAccessor(), corner = corners->getAccessor();
  for (const Vec3d& p : points) cell.setValueOn(Coord::floor(transform->worldToIndex(p)));
  for (auto at = cells->cbeginValueOn(); at; ++at)
    for (int c = 0; c < 8; ++c) corner.setValueOn(at.getCoord().offsetBy(c & 1, c >> 1 & 1, c >> 2));
  corners->setTransform(transform);
  return corners;
}

/// How far what is at each point moves while the weights change by `change`, by its velocity at `weights`.
std::vector<Vec3d> steps(const MorphPlan& plan, const std::vector<Vec3d>& points, const Weights& weights,
                         const Weights& change, double voxelSize) {
  const openvdb::Vec3SGrid::Ptr velocity = plan.carrier(weights).velocity(*cornersAround(points, voxelSize), change);
  std::vector<Vec3d> result(points.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, points.size()), [&](const tbb::blocked_range<size_t>& part) {
    openvdb::tools::GridSampler<openvdb::Vec3SGrid::ConstAccessor, openvdb::tools::BoxSampler> sample(
        velocity->getConstAccessor(), velocity->transform());
    for (size_t i = part.begin(); i < part.end(); ++i) result[i] = Vec3d(sample.wsSample(points[i]));
  });
  return result;
}

Weights between(const Weights& from, const Weights& to, double share) {
  Weights result(from.size());
  for (size_t k = 0; k < from.size(); ++k) result[k] = (1 - share) * from[k] + share * to[k];
  return result;
}

}  // namespace

std::vector<Vec3d> ride(const MorphPlan& plan, std::vector<Vec3d> points, const Weights& from, const Weights& to,
                        double voxelSize) {
  double most = 0;
  for (size_t k = 0; k < from.size(); ++k) most = std::max(most, std::abs(to[k] - from[k]));
  const int count = int(std::ceil(most / kMostStep - 1e-9));
  Weights change(from.size());
  for (size_t k = 0; k < from.size(); ++k) change[k] = (to[k] - from[k]) / std::max(count, 1);
  for (int step = 0; step < count; ++step) {
    const Weights before = between(from, to, double(step) / count), after = between(from, to, double(step + 1) / count);
    const std::vector<Vec3d> first = steps(plan, points, before, change, voxelSize);
    std::vector<Vec3d> guess(points.size());
    for (size_t i = 0; i < points.size(); ++i) guess[i] = points[i] + first[i];
    const std::vector<Vec3d> second = steps(plan, guess, after, change, voxelSize);
    for (size_t i = 0; i < points.size(); ++i) points[i] += (first[i] + second[i]) / 2;
  }
  return points;
}

}  // namespace slicemorph

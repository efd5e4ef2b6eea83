#include "engine/match/core_points.h"

#include "engine/match/meeting_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Parts are thin where no point is deeper than this fraction of the objects' size.
constexpr double kThin = 0.06;
/// A point is as deep as its surroundings where distances change by less than this per unit: on the way from one wall to
/// the other they change by 1, turn round, and change by 1 again.
constexpr double kRidge = 0.75;
/// Nodes less deep than this, in spacings, say little.
constexpr double kLeastDepth = 0.3;
/// Steps on the way to the deepest point nearby, voxels; and what depth must grow by on each, of its length.
constexpr double kStep = 0.5, kGrowth = 0.25;

/// The coarse nodes of a field, world coordinates, that are as deep as any around them and less deep than `most`.
std::vector<Vec3d> coresOf(const DistanceField& field, double most) {
  const openvdb::Coord size = field.size();
  std::vector<std::vector<Vec3d>> slabs;
  slabs.resize(size_t(size[2]));
  tbb::parallel_for(1, size[2] - 1, [&](int z) {
    for (int y = 1; y + 1 < size[1]; ++y)
      for (int x = 1; x + 1 < size[0]; ++x) {
        const float d = field.nodeDistance(x, y, z);
        if (!(d < -kLeastDepth * field.spacing()) || d < -most) continue;
        const Vec3d change(field.nodeDistance(x + 1, y, z) - field.nodeDistance(x - 1, y, z),
                           field.nodeDistance(x, y + 1, z) - field.nodeDistance(x, y - 1, z),
                           field.nodeDistance(x, y, z + 1) - field.nodeDistance(x, y, z - 1));
        if (change.length() < kRidge * 2 * field.spacing())
          slabs[size_t(z)].push_back(field.nodePosition(x, y, z));
      }
  });
  std::vector<Vec3d> cores;
  for (const std::vector<Vec3d>& slab : slabs) cores.insert(cores.end(), slab.begin(), slab.end());
  return cores;
}

/// The deepest point that one comes to from `p` by going deeper only, from the nearest point of the surface where `p` is
/// outside; world coordinates. At most `most` deep.
Vec3d deeper(const DistanceField& field, const DistanceField::Sampler& sample, const Vec3d& p, double most) {
  const double step = kStep * field.voxelSize();
  openvdb::Vec3s at = field.relative(p);
  if (sample(at) > 0) at = field.relative(field.closest(p));
  float depth = -sample(at);
  for (double gone = 0; gone < most; gone += step) {
    const openvdb::Vec3s next = at - sample.gradient(at) * float(step);
    const float there = -sample(next);
    if (there < depth + float(kGrowth * step)) break;
    at = next, depth = there;
  }
  return field.anchor() + Vec3d(at);
}

}  // namespace

std::vector<Correspondence> corePoints(const MatchObjects& objects, const Matching& matching, double reach) {
  const size_t count = objects.count();
  std::vector<Correspondence> points;
  for (size_t j = 0; j < count; ++j) {
    const DistanceField& field = *objects.shape.fields[j];
    OrientedPoints cores;
    for (const Vec3d& p : coresOf(field, kThin * objects.size * objects.charts[j].meanScale()))
      cores.position.push_back(objects.charts[j].toChart(p));
    cores.normal.resize(cores.position.size(), Vec3d(0.0)), cores.mass.resize(cores.position.size(), 1);
    const auto project = [&](size_t k, const Vec3d& before, size_t) {
      const DistanceField& other = *objects.shape.fields[k];
      const Chart& chart = objects.charts[k];
      const Vec3d core = chart.toChart(deeper(other, DistanceField::Sampler(other), chart.toWorld(before),
                                              kThin * objects.size * chart.meanScale()));
      const double trust = trustAt((core - before).length(), reach);
      return Projected{trust > 0 ? core : before, float(trust)};
    };
    for (Correspondence& c :
         meetingPoints(j, count, matching.map, middleSamples(matching, j, cores), project))
      points.push_back(std::move(c));
  }
  return points;
}

}  // namespace slicemorph

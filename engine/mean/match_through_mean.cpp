#include "engine/mean/match_through_mean.h"

#include "engine/blend/moving_lattice.h"
#include "engine/match/features.h"
#include "engine/match/fold_guard.h"
#include "engine/rebuild/rebuild.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

namespace slicemorph {

namespace {

/// Voxels of the mean along the lattice's longest side.
constexpr double kVoxels = 128;
constexpr int kNodeStep = 4;

/// The mean of the objects by a map.
struct Mean {
  Chart chart;
  std::shared_ptr<const DistanceField> field;
};

Mean meanOf(const Displacements& map, const Fields& fields, const std::vector<Chart>& charts) {
  const Weights equal(fields.size(), 1.0 / double(fields.size()));
  const MovingLattice lattice(map, fields, charts);
  const MovingLattice::Pose pose = lattice.poseAt(equal);
  const openvdb::Coord& n = map.lattice.size;
  const double voxel = pose.chart.meanScale() * map.lattice.spacing * std::max({n[0], n[1], n[2]}) / kVoxels;
  const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
  DistanceBlend blend{lattice.localWeights(equal), {}, pose.chart.meanScale()};
  for (const Chart& chart : charts) blend.sizes.push_back(chart.meanScale());
  const FloatGrid::Ptr surface =
      rebuildLevelSet(lattice.nodesNearSurface(pose, *transform, kNodeStep), fields, blend, *transform);
  if (surface->empty()) return {pose.chart, nullptr};
  return {pose.chart, std::make_shared<DistanceField>(surface)};
}

/// The places that a displacement takes to each node of a lattice.
std::vector<Vec3d> sourcesOf(const Lattice& nodes, const Lattice& lattice, const VectorField& displacement) {
  const MiddleGuess guess(lattice, displacement);
  std::vector<Vec3d> sources(nodes.count());
  tbb::parallel_for(0, int(nodes.size[2]), [&](int z) {
    for (int y = 0; y < nodes.size[1]; ++y)
      for (int x = 0; x < nodes.size[0]; ++x) {
        const Vec3d place = nodes.position(x, y, z), start = guess.near(place);
        Vec3d& s = sources[nodes.index(x, y, z)] = start;
        if (!toMiddleContinued(lattice, displacement, place, s)) s = start;  // where it has a fold
      }
  });
  return sources;
}

/// How far from each node of a lattice lies what a field takes its source to.
VectorField displacementFrom(const std::vector<Vec3d>& sources, const Lattice& nodes, const Lattice& lattice,
                             const VectorField& field) {
  VectorField result(nodes.count());
  tbb::parallel_for(0, int(nodes.size[2]), [&](int z) {
    for (int y = 0; y < nodes.size[1]; ++y)
      for (int x = 0; x < nodes.size[0]; ++x) {
        const size_t i = nodes.index(x, y, z);
        result[i] = openvdb::Vec3s(sources[i] + sampleContinued(lattice, field, sources[i]) -
                                   nodes.position(x, y, z));
      }
  });
  return result;
}

/// The displacements of a pair's second object from the places of its first one, the mean.
VectorField fromMean(const Displacements& pair, const Lattice& nodes) {
  return displacementFrom(sourcesOf(nodes, pair.lattice, pair.of[0]), nodes, pair.lattice, pair.of[1]);
}

/// The same map from a space in which every place is the mean of those on the objects.
Displacements recentred(const Displacements& map) {
  const Lattice& lattice = map.lattice;
  Displacements mean{lattice, {VectorField(lattice.count(), openvdb::Vec3s(0.f))}};
  for (const VectorField& field : map.of)
    for (size_t i = 0; i < field.size(); ++i) mean.of[0][i] += float(1.0 / double(map.of.size())) * field[i];
  removeFolds(mean);
  const std::vector<Vec3d> sources = sourcesOf(lattice, lattice, mean.of[0]);
  Displacements result{lattice, {}};
  for (const VectorField& field : map.of)
    result.of.push_back(displacementFrom(sources, lattice, lattice, field));
  return result;
}

/// Where features are half way by a map, world places of the mean; lines by nine places along them.
std::vector<Feature> featuresOfPair(const std::vector<Feature>& features, size_t object,
                                    const Displacements& map, const std::vector<Chart>& charts,
                                    const Mean& mean) {
  std::vector<Feature> result;
  for (const Feature& feature : features) {
    Feature pair{feature.name, feature.kind, {{}, feature.places[object]}, {}, {}};
    const double share = 1.0 / double(charts.size());
    const auto middle = [&](auto placeOn) {
      Vec3d sum(0.0);
      for (size_t k = 0; k < charts.size(); ++k) {
        const Vec3d a = charts[k].toChart(placeOn(k));
        Vec3d s = a - map.at(k, a);
        sum += share * (toMiddle(map, k, a, s) ? s : a);
      }
      return mean.chart.toWorld(sum);
    };
    const size_t count = feature.kind == Feature::Kind::kLine ? 9 : 1;
    for (size_t i = 0; i < count; ++i)
      pair.places[0].push_back(middle([&](size_t k) {
        return placeAlong(feature.places[k], count > 1 ? double(i) / double(count - 1) : 0);
      }));
    if (feature.kind == Feature::Kind::kDisk) {
      const Vec3d ahead = middle(
          [&](size_t k) { return feature.places[k][0] + feature.radii[k] * feature.normals[k].unit(); });
      double radius = 0;
      for (size_t k = 0; k < charts.size(); ++k) radius += share * feature.radii[k] / charts[k].meanScale();
      pair.normals = {ahead - pair.places[0][0], feature.normals[object]};
      pair.radii = {radius * mean.chart.meanScale(), feature.radii[object]};
    }
    result.push_back(std::move(pair));
  }
  return result;
}

}  // namespace

Registration matchThroughMean(Registration start, const Fields& fields, const std::vector<Fields>& inner,
                              const Frames& frames, const std::vector<std::string>& names,
                              const MorphOptions& options, Progress& progress) {
  Registration result = std::move(start);
  const std::vector<Chart>& charts = frames.charts;
  const Mean mean = meanOf(result.map, fields, charts);
  if (!mean.field) return result;
  Displacements next{result.map.lattice, std::vector<VectorField>(fields.size())};
  std::vector<std::string> found(fields.size());
  std::atomic<size_t> done{0};
  tbb::parallel_for(size_t(0), fields.size(), [&](size_t k) {
    if (progress.cancelled()) return;
    Frames pair;
    pair.charts = {mean.chart, charts[k]};
    pair.halfLength = frames.halfLength;
    MorphOptions own = options;
    own.features = featuresOfPair(options.features, k, result.map, charts, mean);
    Progress none;
    const Registration match = registerObjects({mean.field, fields[k]}, {}, pair, own, none, false);
    char text[256];
    std::snprintf(text, sizeof text, "%s and the mean: overlap %.3f, matched %.3f", names[k].c_str(),
                  match.overlapBefore, match.overlapAfter);
    found[k] = text;
    next.of[k] = fromMean(match.map, next.lattice);
    progress.report("match", 0.2 + 0.7 * double(++done) / double(fields.size()));
  });
  if (progress.cancelled()) throw Cancelled();
  result.notes.insert(result.notes.end(), found.begin(), found.end());
  removeFolds(next);
  result.map = recentred(next);
  removeFolds(result.map);
  return refineRegistration(std::move(result), fields, inner, frames, options, progress);
}

}  // namespace slicemorph

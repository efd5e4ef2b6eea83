#include "engine/mean/match_through_mean.h"

#include "engine/blend/moving_lattice.h"
#include "engine/match/features.h"
#include "engine/match/fold_guard.h"
#include "engine/rebuild/in_between.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdio>
#include <mutex>

namespace slicemorph {

namespace {

/// Voxels of the mean along the lattice's longest side; fewer where the objects' own are larger. Chosen by hand.
constexpr double kMeanVoxels = 128;

/// The mean shape of the objects by a map.
struct Mean {
  Chart chart;
  std::shared_ptr<const DistanceField> field;  ///< null if the mean is empty
};

Mean meanOf(const Displacements& map, const MatchObjects& objects, const Frames& frames) {
  const Fields& fields = objects.shape.fields;
  const Weights equal(fields.size(), 1.0 / double(fields.size()));
  const MovingLattice lattice(map, fields, frames.charts);
  const auto pose = std::make_shared<const MovingLattice::Pose>(lattice.poseAt(equal));
  const openvdb::Coord& n = map.lattice.size;
  const double finest = map.lattice.spacing * std::max({n[0], n[1], n[2]}) / kMeanVoxels;
  const double voxelSize = pose->chart.meanScale() * std::max(finest, objects.smallestVoxel());
  const FloatGrid::Ptr surface =
      rebuildInBetween({lattice, fields, frames}, equal, pose, voxelSize).shape.surface;
  if (surface->empty()) return {pose->chart, nullptr};
  return {pose->chart, std::make_shared<DistanceField>(surface)};
}

/// Per node of `nodes` the point that a displacement takes there (inverse of the displacement).
std::vector<Vec3d> sourcesOf(const Lattice& nodes, const Lattice& lattice, const VectorField& displacement) {
  const MiddleGuess guess(lattice, displacement);
  std::vector<Vec3d> sources(nodes.count());
  tbb::parallel_for(0, int(nodes.size[2]), [&](int z) {
    for (int y = 0; y < nodes.size[1]; ++y)
      for (int x = 0; x < nodes.size[0]; ++x) {
        const Vec3d position = nodes.position(x, y, z), start = guess.near(position);
        Vec3d& s = sources[nodes.index(x, y, z)] = start;
        if (!toMiddleContinued(lattice, displacement, position, s)) s = start;  // where it has a fold
      }
  });
  return sources;
}

/// Per node, the displacement from the node to where `field` takes the node's source.
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

/// The displacements of a pair's second object from points of the first one, the mean.
VectorField fromMean(const Displacements& pair, const Lattice& nodes) {
  return displacementFrom(sourcesOf(nodes, pair.lattice, pair.of[0]), nodes, pair.lattice, pair.of[1]);
}

/// The same map, from a middle space in which every point is the mean of its positions on the objects.
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

/// The features for the pair of the mean (first) and an object: on the mean they are at the positions half
/// way by the map, world units; lines by nine points along them.
std::vector<Feature> featuresOfPair(const std::vector<Feature>& features, size_t object,
                                    const Displacements& map, const std::vector<Chart>& charts,
                                    const Mean& mean) {
  std::vector<Feature> result;
  for (const Feature& feature : features) {
    Feature pair{feature.name, feature.kind, {{}, feature.positions[object]}, {}, {}};
    const double share = 1.0 / double(charts.size());
    const auto middle = [&](auto positionOn) {
      Vec3d sum(0.0);
      for (size_t k = 0; k < charts.size(); ++k) {
        const Vec3d a = charts[k].toChart(positionOn(k));
        Vec3d s = a - map.at(k, a);
        sum += share * (toMiddle(map, k, a, s) ? s : a);
      }
      return mean.chart.toWorld(sum);
    };
    const size_t count = feature.kind == Feature::Kind::kLine ? 9 : 1;
    for (size_t i = 0; i < count; ++i)
      pair.positions[0].push_back(middle([&](size_t k) {
        return pointAlong(feature.positions[k], count > 1 ? double(i) / double(count - 1) : 0);
      }));
    if (feature.kind == Feature::Kind::kDisk) {
      const Vec3d ahead = middle(
          [&](size_t k) { return feature.positions[k][0] + feature.radii[k] * feature.normals[k].unit(); });
      double radius = 0;
      for (size_t k = 0; k < charts.size(); ++k) radius += share * feature.radii[k] / charts[k].meanScale();
      pair.normals = {ahead - pair.positions[0][0], feature.normals[object]};
      pair.radii = {radius * mean.chart.meanScale(), feature.radii[object]};
    }
    result.push_back(std::move(pair));
  }
  return result;
}

/// Matches the mean and object k as a pair. `map`: of all objects, by which the mean was made.
Registration matchedWithMean(const MatchObjects& objects, size_t k, const Displacements& map,
                             const Mean& mean, const MorphOptions& options) {
  const MatchObjects pair =
      measureObjects({mean.field, objects.shape.fields[k]}, {}, {mean.chart, objects.charts[k]},
                     featuresOfPair(objects.features, k, map, objects.charts, mean));
  const TracedObjects traced = traceObjects(sliceObjects(pair, options.slices));
  Progress none;
  return registerObjects(pair, traced, options.samples, kRoundsBeforeLast, none);
}

}  // namespace

Registration matchThroughMean(Registration start, const MatchObjects& objects, const Frames& frames,
                              const std::vector<std::string>& names, const MorphOptions& options,
                              Progress& progress) {
  Registration result = std::move(start);
  const size_t count = objects.count();
  const Mean mean = meanOf(result.map, objects, frames);
  if (!mean.field) return result;
  Displacements next{result.map.lattice, std::vector<VectorField>(count)};
  Notes found(count);
  size_t done = 0;
  std::mutex reporting;  // so that reports come in their order
  tbb::parallel_for(size_t(0), count, [&](size_t k) {
    if (progress.cancelled()) return;
    const Registration match = matchedWithMean(objects, k, result.map, mean, options);
    char text[96];
    std::snprintf(text, sizeof text, "overlaps the mean by %.3f, matched by %.3f", match.overlapBefore,
                  match.overlapAfter);
    found[k] = {"match.mean", Severity::kDetail, names[k], text};
    next.of[k] = fromMean(match.map, next.lattice);
    const std::lock_guard<std::mutex> lock(reporting);
    progress.report("match", 0.2 + 0.7 * double(++done) / double(count));
  });
  if (progress.cancelled()) throw Cancelled();
  result.notes.insert(result.notes.end(), found.begin(), found.end());
  removeFolds(next);
  result.map = recentred(next);
  removeFolds(result.map);
  return refineRegistration(std::move(result), objects, progress);
}

}  // namespace slicemorph

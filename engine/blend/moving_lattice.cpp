#include "engine/blend/moving_lattice.h"

#include "engine/blend/lay_along_spine.h"
#include "engine/blend/surface_nodes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace slicemorph {

namespace {

/// Change of the weights for the velocities' central differences: small against the map's changes,
/// large against rounding.
constexpr double kWeightStep = 1e-3;
/// Most rounds of widening borders (each with twice as many smoothings as the one before) or of straightening
/// paths. Chosen by hand; seven rounds leave 0.7^7 = 8 % of the paths' offsets.
constexpr int kMostStraightening = 7;

void straighten(VectorField& offsets) {
  for (openvdb::Vec3s& offset : offsets) offset *= 0.7f;
}

Weights allOf(size_t object, size_t objects) {
  Weights alone(objects, 0);
  alone[object] = 1;
  return alone;
}

}  // namespace

MovingLattice::MovingLattice(const Displacements& map, const Fields& fields, const std::vector<Chart>& charts,
                             std::shared_ptr<const RegionShares> regions,
                             std::shared_ptr<const ContourPaths> paths, bool swings)
    : on_(latticeOnObjects(map, fields, charts)), regions_(std::move(regions)), paths_(std::move(paths)) {
  if (swings) swings_.emplace(on_);
  bool bent = false;
  for (const Chart& c : charts) bent |= !c.bend.straight();
  for (size_t k = 0; k < on_.objects() && bent; ++k) centroid_.push_back(centroidOf(k, charts[k]));
  for (size_t r = 0; regions_ && r < regions_->count(); ++r) {
    const VectorField& position = on_.position[regions_->region(r).object];
    share_.emplace_back(position.size());
    tbb::parallel_for(size_t(0), position.size(),
                      [&](size_t i) { share_[r][i] = regions_->at(r, position[i]); });
  }
}

void MovingLattice::passSmoothly(const std::array<PathTangents::Neighbour, 2>& of) {
  tangents_ = std::make_unique<PathTangents>(on_, of);
}

Vec3d MovingLattice::centroidOf(size_t object, const Chart& chart) const {
  const Pose pose = blendedPose(on_, allOf(object, on_.objects()), {}, {});
  return poseCentroid(on_.lattice, pose, worldOf(pose, chart), chart);
}

MovingLattice::Pose MovingLattice::poseAt(const Weights& weights) const {
  return poseAt(weights, std::nullopt);
}

/// `straightening`: number of rounds, as in an earlier pose; nullopt: as many as it takes.
MovingLattice::Pose MovingLattice::poseAt(const Weights& weights, std::optional<int> straightening) const {
  Pose pose = uncentredPose(weights, straightening);
  if (!centroid_.empty()) pose.chart.center += shiftToCentre(pose, worldOf(pose, pose.chart));
  pose.world = worldOf(pose, pose.chart);
  return pose;
}

/// A pose without its world positions, whose chart is where those of the objects lead to.
MovingLattice::Pose MovingLattice::uncentredPose(const Weights& weights,
                                                 std::optional<int> straightening) const {
  const NodeWeights local = nodeWeights(weights);
  Pose pose = blendUnfolded(weights, local, straightening);
  if (local.empty()) pose.chart = blendCharts(on_.charts, weights);
  return pose;
}

/// By how much a pose has to be moved so that the centroid's path is straight; 0 where charts are straight.
Vec3d MovingLattice::shiftToCentre(const Pose& pose, const std::vector<Vec3d>& world) const {
  if (centroid_.empty()) return Vec3d(0.0);
  Vec3d wanted(0.0);
  for (size_t k = 0; k < on_.objects(); ++k) wanted += pose.mean[k] * centroid_[k];
  return wanted - poseCentroid(on_.lattice, pose, world, pose.chart);
}

MovingLattice::Pose MovingLattice::poseOf(size_t object) const {
  Pose pose = blendedPose(on_, allOf(object, on_.objects()), {}, {});
  pose.chart = on_.charts[object];
  pose.world = worldOf(pose, pose.chart);
  return pose;
}

NodeWeights MovingLattice::nodeWeights(const Weights& weights) const {
  if (share_.empty()) return {};
  const size_t objects = on_.objects(), count = on_.lattice.count();
  const LocalWeights local = localWeights(weights);
  NodeWeights result(count * objects);
  tbb::parallel_for(size_t(0), count, [&](size_t i) {
    std::vector<float> shares(share_.size());
    Weights own(objects);
    for (size_t r = 0; r < shares.size(); ++r) shares[r] = share_[r][i];
    local.blend(shares.data(), own.data());
    std::copy(own.begin(), own.end(), &result[i * objects]);
  });
  return result;
}

/// Of each node from the map's own path; empty: there are none.
VectorField MovingLattice::offsetsAt(const Weights& weights) const {
  VectorField offsets;
  if (paths_)
    offsets = paths_->offsets(weights, on_.lattice);
  else if (swings_)
    offsets = swings_->offsets(weights);
  if (tangents_) tangents_->add(weights, offsets);
  return offsets;
}

/// Moves every node's weights half way to the mean of its neighbours'.
NodeWeights MovingLattice::smoothed(const NodeWeights& weights) const {
  const Lattice& lattice = on_.lattice;
  const size_t objects = on_.objects();
  const size_t row = size_t(lattice.size[0]) * objects;
  NodeWeights result(weights.size());
  tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
    for (int y = 0; y < lattice.size[1]; ++y) {
      // A node beyond the lattice has the weights of the one at its rim.
      const auto rowAt = [&](int besideY, int besideZ) {
        const openvdb::Coord at(0, std::min(std::max(besideY, 0), lattice.size[1] - 1),
                                std::min(std::max(besideZ, 0), lattice.size[2] - 1));
        return &weights[lattice.index(at) * objects];
      };
      const float *own = rowAt(y, z), *below = rowAt(y - 1, z), *above = rowAt(y + 1, z),
                  *before = rowAt(y, z - 1), *behind = rowAt(y, z + 1);
      float* to = &result[lattice.index(0, y, z) * objects];
      const auto smooth = [&](size_t i, size_t left, size_t right) {
        const float sum =
            own[left] / 6 + own[right] / 6 + below[i] / 6 + above[i] / 6 + before[i] / 6 + behind[i] / 6;
        to[i] = 0.5f * (own[i] + sum);
      };
      for (size_t i = 0; i < objects; ++i) smooth(i, i, std::min(i + objects, row - objects + i));
      for (size_t i = objects; i + objects < row; ++i) smooth(i, i - objects, i + objects);
      for (size_t i = std::max(objects, row - objects); i < row; ++i) smooth(i, i - objects, i);
    }
  });
  return result;
}

/// Blends a pose; widens the borders between regions, or straightens the paths, until nothing folds.
MovingLattice::Pose MovingLattice::blendUnfolded(const Weights& weights, const NodeWeights& local,
                                                 std::optional<int> straightening) const {
  // With regions, paths are the map's own.
  VectorField offsets = local.empty() ? offsetsAt(weights) : VectorField();
  NodeWeights wider = local;
  const auto made = [&] {
    Pose pose = blendedPose(on_, weights, wider, offsets);
    if (local.empty()) return pose;
    // The distances are blended by the prescribed weights, not the smoothed ones.
    if (wider != local) pose.distance = blendedPose(on_, weights, local, {}).distance;
    return layAlongSpine(on_.charts, wider, std::move(pose));
  };
  Pose pose = made();
  if (local.empty() && offsets.empty()) return pose;
  int rounds = 0;
  while (straightening ? rounds < *straightening
                       : rounds < kMostStraightening && poseFolds(on_, pose, local)) {
    for (int i = 0; i < 1 << rounds && !local.empty(); ++i) wider = smoothed(wider);
    straighten(offsets);
    pose = made();
    ++rounds;
  }
  pose.straightening = rounds;
  return pose;
}

std::vector<Vec3d> MovingLattice::carryPoints(const std::vector<Vec3d>& points, const Pose& from,
                                              const Pose& to) const {
  const Lattice& lattice = on_.lattice;
  const VectorField here = displacementOf(lattice, from), there = displacementOf(lattice, to);
  const MiddleGuess guess(lattice, here);
  std::vector<Vec3d> result(points.size());
  tbb::parallel_for(size_t(0), points.size(), [&](size_t i) {
    const Vec3d a = from.chart.toChart(points[i]), start = guess.near(a);
    Vec3d s = start;
    if (!toMiddleContinued(lattice, here, a, s)) s = start;  // where the map has a fold
    result[i] = to.chart.toWorld(s + sampleContinued(lattice, there, s));
  });
  return result;
}

NodeMap MovingLattice::nodesNearSurface(const Pose& pose, const openvdb::math::Transform& transform,
                                        int step) const {
  return surfaceNodes(on_, pose, transform, step);
}

openvdb::BBoxd MovingLattice::boxOf(size_t object, const openvdb::BBoxd& world, const Pose& pose,
                                    const openvdb::math::Transform& transform) const {
  return boxOnPose(on_, object, world, pose, transform);
}

NodeMap MovingLattice::nodesWithin(const openvdb::CoordBBox& box, const Pose& pose,
                                   const openvdb::math::Transform& transform, int step) const {
  const auto beyond = [&](const Vec3d& q, size_t k) {
    return openvdb::Vec3s(on_.charts[k].toWorld(q) - on_.anchor[k]);
  };
  NodeMap map = boxNodes(box, on_.lattice, pose, transform, step, {positionFields(on_), beyond});
  map.jump = longestJumps(on_, pose.chart, transform, step);
  return map;
}

/// The same where neither weights differ by region nor charts are bent: from node to node, without whole poses.
LatticeMotion MovingLattice::plainMotion(const Weights& earlier, const Weights& later, double unit,
                                         int straightening) const {
  struct End {
    Chart chart;
    Weights path;
    VectorField offsets;
  };
  const auto endAt = [&](const Weights& weights) {
    End end{blendCharts(on_.charts, weights), pathWeights(weights), offsetsAt(weights)};
    for (int round = 0; round < straightening; ++round) straighten(end.offsets);
    return end;
  };
  const auto ends = std::make_shared<const std::pair<End, End>>(endAt(earlier), endAt(later));
  const auto velocity = [this, ends, unit](size_t i) {
    const Vec3d middle = on_.lattice.position(on_.lattice.coordOf(i));
    const auto world = [&](const End& end) {
      Vec3d q = onPath(on_, i, middle, end.path);
      if (!end.offsets.empty()) q += Vec3d(end.offsets[i]);
      return end.chart.toWorld(q);
    };
    return openvdb::Vec3s(unit * (world(ends->second) - world(ends->first)));
  };
  return {velocity, ends->first.chart, ends->second.chart, unit};
}

LatticeMotion MovingLattice::motionAt(const Weights& weights, const Weights& rate, const Pose& pose) const {
  // Central differences, also at the objects: the map is defined for weights a little outside 0 to 1.
  double most = 0;
  for (double r : rate) most = std::max(most, std::abs(r));
  const double time = most > 0 ? kWeightStep / most : 0, unit = time > 0 ? 0.5 / time : 0;
  Weights earlier = weights, later = weights;
  for (size_t k = 0; k < on_.objects(); ++k) earlier[k] -= time * rate[k], later[k] += time * rate[k];
  if (share_.empty() && centroid_.empty()) return plainMotion(earlier, later, unit, pose.straightening);
  const auto posed = [&](const Weights& at) {
    Pose one = uncentredPose(at, pose.straightening);
    one.world = worldOf(one, one.chart);
    return one;
  };
  Pose from = posed(earlier), to = posed(later);
  const Vec3d fromShift = shiftToCentre(from, from.world), toShift = shiftToCentre(to, to.world);
  from.chart.center += fromShift, to.chart.center += toShift;
  const auto velocity = std::make_shared<VectorField>(on_.lattice.count());
  const Vec3d shift = toShift - fromShift;
  tbb::parallel_for(size_t(0), velocity->size(), [&](size_t i) {
    (*velocity)[i] = openvdb::Vec3s(unit * (to.world[i] - from.world[i] + shift));
  });
  return {[velocity](size_t i) { return (*velocity)[i]; }, from.chart, to.chart, unit};
}

}  // namespace slicemorph

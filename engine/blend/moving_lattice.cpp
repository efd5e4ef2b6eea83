#include "engine/blend/moving_lattice.h"

#include "engine/match/fold_guard.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

constexpr double kFoldedBelow = 0.05;
/// A point of a face belongs to both its tetrahedra.
constexpr double kOnFace = 1e-6;
/// Chart units; beyond the place where a bent chart's slices cross there is nothing.
constexpr float kNothing = 1e3f;
/// How many times further apart than by the objects' sizes two nodes' places may be.
constexpr double kStretch = 4;
/// By how much weights change for the velocities' differences.
constexpr double kWeightStep = 1e-3;
/// Slabs along the spine whose weights are told apart.
constexpr int kSlabs = 160;
/// Borders are widened in steps, each of twice as many smoothings as the one before, and ways that are not
/// straight straightened, this often at most.
constexpr int kMostStraightening = 7;
/// Neighbouring nodes whose weights differ by less are not at a border.
constexpr float kSameWeight = 1e-3f;

double volumeOf(const Vec3d* p, const int* t) {
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).dot(p[t[3]] - p[t[0]]);
}

/// Calls `action(q, n)` for every node that is not known, with its chart point; it may make the node known.
template <typename Action>
void forUnknownNodes(const NodeMap& map, const Chart& chart, const openvdb::math::Transform& transform,
                     const Action& action) {
  tbb::parallel_for(0, int(map.size[2]), [&](int z) {
    for (int y = 0; y < map.size[1]; ++y)
      for (int x = 0; x < map.size[0]; ++x) {
        const openvdb::Coord c = map.origin + openvdb::Coord(x, y, z);
        const size_t n = map.index(c[0], c[1], c[2]);
        if (!map.known[n]) action(chart.toChart(transform.indexToWorld(map.step * c.asVec3d())), n);
      }
  });
}

}  // namespace

MovingLattice::MovingLattice(const Displacements& map, const Fields& fields, const std::vector<Chart>& charts,
                             std::shared_ptr<const RegionShares> regions,
                             std::shared_ptr<const ContourPaths> paths)
    : lattice_(map.lattice),
      charts_(charts),
      objects_(fields.size()),
      chart_(map.of),
      place_(map.of),
      distance_(objects_),
      regions_(std::move(regions)),
      paths_(std::move(paths)) {
  for (size_t k = 0; k < objects_; ++k) {
    anchor_.push_back(fields[k]->anchor());
    distance_[k].resize(lattice_.count());
    const double unit = 1 / charts[k].meanScale();
    tbb::parallel_for(0, int(lattice_.size[2]), [&](int z) {
      for (int y = 0; y < lattice_.size[1]; ++y)
        for (int x = 0; x < lattice_.size[0]; ++x) {
          const size_t i = lattice_.index(x, y, z);
          chart_[k][i] += openvdb::Vec3s(lattice_.position(x, y, z));
          const Vec3d world = charts[k].toWorld(Vec3d(chart_[k][i]));
          place_[k][i] = fields[k]->relative(world);
          const bool crossed = charts[k].spread(Vec3d(chart_[k][i])) <= 0;
          distance_[k][i] = crossed ? kNothing : float(unit * fields[k]->coarse(world));
        }
    });
  }
  bool bent = false;
  for (const Chart& c : charts) bent |= !c.bend.straight();
  for (size_t k = 0; k < objects_ && bent; ++k) {
    Weights alone(objects_, 0);
    alone[k] = 1;
    centroid_.push_back(centroid(blend(alone, {}, {}), charts[k]));
  }
  for (size_t r = 0; regions_ && r < regions_->count(); ++r) {
    const VectorField& place = place_[regions_->region(r).object];
    share_.emplace_back(place.size());
    tbb::parallel_for(size_t(0), place.size(), [&](size_t i) { share_[r][i] = regions_->at(r, place[i]); });
  }
}

MovingLattice::Pose MovingLattice::poseAt(const Weights& weights) const {
  return poseAt(weights, std::nullopt);
}

/// `straightening`: as an earlier pose's; none: found.
MovingLattice::Pose MovingLattice::poseAt(const Weights& weights, std::optional<int> straightening) const {
  const NodeWeights local = nodeWeights(weights);
  Pose pose = blendUnfolded(weights, local, straightening);
  if (local.empty()) pose.chart = blendCharts(charts_, weights);
  if (!centroid_.empty()) {
    Vec3d wanted(0.0);
    for (size_t k = 0; k < objects_; ++k) wanted += pose.mean[k] * centroid_[k];
    pose.chart.center += wanted - centroid(pose, pose.chart);
  }
  pose.world.resize(pose.at.size());
  tbb::parallel_for(size_t(0), pose.at.size(),
                    [&](size_t i) { pose.world[i] = pose.chart.toWorld(pose.at[i]); });
  return pose;
}

MovingLattice::Pose MovingLattice::poseOf(size_t object) const {
  Weights alone(objects_, 0);
  alone[object] = 1;
  Pose pose = blend(alone, {}, {});
  pose.chart = charts_[object];
  pose.world.resize(pose.at.size());
  tbb::parallel_for(size_t(0), pose.at.size(),
                    [&](size_t i) { pose.world[i] = pose.chart.toWorld(pose.at[i]); });
  return pose;
}

MovingLattice::NodeWeights MovingLattice::nodeWeights(const Weights& weights) const {
  if (share_.empty()) return {};
  const LocalWeights local = localWeights(weights);
  NodeWeights result(lattice_.count() * objects_);
  tbb::parallel_for(size_t(0), lattice_.count(), [&](size_t i) {
    std::vector<float> shares(share_.size());
    Weights own(objects_);
    for (size_t r = 0; r < shares.size(); ++r) shares[r] = share_[r][i];
    local.blend(shares.data(), own.data());
    std::copy(own.begin(), own.end(), &result[i * objects_]);
  });
  return result;
}

/// Every node's weights half way to the mean of its neighbours'.
MovingLattice::NodeWeights MovingLattice::smoothed(const NodeWeights& weights) const {
  NodeWeights result(weights.size());
  tbb::parallel_for(0, int(lattice_.size[2]), [&](int z) {
    for (int y = 0; y < lattice_.size[1]; ++y)
      for (int x = 0; x < lattice_.size[0]; ++x) {
        const openvdb::Coord c(x, y, z);
        for (size_t k = 0; k < objects_; ++k) {
          float sum = 0;
          for (int axis = 0; axis < 3; ++axis)
            for (int way : {-1, 1}) {
              openvdb::Coord n = c;
              n[axis] = std::min(std::max(c[axis] + way, 0), lattice_.size[axis] - 1);
              sum += weights[lattice_.index(n[0], n[1], n[2]) * objects_ + k] / 6;
            }
          const size_t i = lattice_.index(x, y, z) * objects_ + k;
          result[i] = 0.5f * (weights[i] + sum);
        }
      }
  });
  return result;
}

/// A border between parts that do not fit together is made wider, and ways that are not straight straighter,
/// until nothing folds.
MovingLattice::Pose MovingLattice::blendUnfolded(const Weights& weights, const NodeWeights& local,
                                                 std::optional<int> straightening) const {
  // Where weights differ from place to place ways are straight.
  VectorField offsets = paths_ && local.empty() ? paths_->offsets(weights, lattice_) : VectorField();
  NodeWeights wider = local;
  const auto made = [&] {
    Pose pose = blend(weights, wider, offsets);
    if (local.empty()) return pose;
    // How near the surface is follows from the weights that were asked for.
    if (wider != local) pose.distance = blend(weights, local, {}).distance;
    layAlongSpine(wider, pose);
    return pose;
  };
  Pose pose = made();
  if (local.empty() && offsets.empty()) return pose;
  int rounds = 0;
  while (straightening ? rounds < *straightening : rounds < kMostStraightening && folds(pose, local)) {
    for (int i = 0; i < 1 << rounds && !local.empty(); ++i) wider = smoothed(wider);
    for (openvdb::Vec3s& offset : offsets) offset *= 0.7f;
    pose = made();
    ++rounds;
  }
  pose.straightening = rounds;
  return pose;
}

/// Whether anything near the surface folds; where weights differ, at their borders.
bool MovingLattice::folds(const Pose& pose, const NodeWeights& local) const {
  const auto border = [&](const size_t(&corner)[8]) {
    for (size_t k = 0; k < objects_ && !local.empty(); ++k)
      for (int c = 1; c < 8; ++c)
        if (std::abs(local[corner[c] * objects_ + k] - local[corner[0] * objects_ + k]) > kSameWeight)
          return true;
    return local.empty();
  };
  std::vector<char> found(lattice_.size[2], 0);
  const double cell = lattice_.spacing * lattice_.spacing * lattice_.spacing;
  tbb::parallel_for(0, int(lattice_.size[2]) - 1, [&](int z) {
    for (int y = 0; y + 1 < lattice_.size[1]; ++y)
      for (int x = 0; x + 1 < lattice_.size[0]; ++x) {
        Vec3d p[8];
        size_t corner[8];
        float nearest = 1e30f;
        for (int c = 0; c < 8; ++c) {
          corner[c] = lattice_.index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
          p[c] = pose.at[corner[c]], nearest = std::min(nearest, pose.distance[corner[c]]);
        }
        if (nearest > 2 * lattice_.spacing || !border(corner)) continue;
        for (const auto& t : kKuhnTetrahedra) found[z] |= !(volumeOf(p, t) > kFoldedBelow * cell);
      }
  });
  return std::find(found.begin(), found.end(), 1) != found.end();
}

/// Where weights differ from place to place each part keeps the size it has on its objects: thickness node by
/// node, length slice by slice, so that slices never overtake each other. One chart holds them all, turned
/// and placed as the mean.
void MovingLattice::layAlongSpine(const NodeWeights& local, Pose& pose) const {
  double low = 1e300, high = -1e300;
  for (const Vec3d& q : pose.at) low = std::min(low, q[0]), high = std::max(high, q[0]);
  const double step = (high - low) / kSlabs;
  const auto slabOf = [&](double z0) { return std::min(std::max(int((z0 - low) / step), 0), kSlabs - 1); };
  std::vector<Weights> slab(kSlabs, Weights(objects_, 0));
  std::vector<double> inside(kSlabs, 0);
  pose.mean.assign(objects_, 0);
  double all = 0;
  const bool any = *std::min_element(pose.distance.begin(), pose.distance.end()) <= 0;
  for (size_t i = 0; i < pose.at.size(); ++i) {
    if (any && pose.distance[i] > 0) continue;
    const int s = slabOf(pose.at[i][0]);
    for (size_t k = 0; k < objects_; ++k) slab[size_t(s)][k] += double(local[i * objects_ + k]);
    ++inside[size_t(s)];
  }
  for (int s = 0; s < kSlabs; ++s)
    for (size_t k = 0; k < objects_; ++k) pose.mean[k] += slab[size_t(s)][k], all += slab[size_t(s)][k];
  for (double& w : pose.mean) w /= all;
  // Slabs with nothing inside take the nearest ones' weights.
  int last = -1;
  for (int s = 0; s < kSlabs; ++s) {
    if (inside[size_t(s)] == 0) continue;
    for (double& w : slab[size_t(s)]) w /= inside[size_t(s)];
    const int middle = last < 0 ? 0 : (last + s + 1) / 2;
    for (int n = last + 1; n < s; ++n) slab[size_t(n)] = n < middle ? slab[size_t(last)] : slab[size_t(s)];
    last = s;
  }
  for (int n = last + 1; n < kSlabs && last >= 0; ++n) slab[size_t(n)] = slab[size_t(last)];

  pose.chart = blendCharts(charts_, pose.mean);
  std::vector<double> length(kSlabs + 1, 0);  // of the spine up to each slab, world units
  for (int s = 0; s < kSlabs; ++s) {
    double scale = 0;
    for (size_t k = 0; k < objects_; ++k) scale += slab[size_t(s)][k] * charts_[k].scale[0];
    length[size_t(s) + 1] = length[size_t(s)] + step * scale;
  }
  const auto lengthAt = [&](double z0) {
    const int s = slabOf(z0);
    return length[size_t(s)] + (length[size_t(s) + 1] - length[size_t(s)]) * ((z0 - low) / step - s);
  };
  const double origin = lengthAt(0);
  if (!pose.chart.bend.straight()) {
    // Stations lie evenly on the whole spine; what turns there is what the objects' own slices do, stretched
    // as they are.
    std::vector<Vec3d> rates(Bend::kStations, Vec3d(0.0));
    for (int i = 0; i < Bend::kStations; ++i) {
      const double at = pose.chart.bend.stationPlace(i) * pose.chart.scale[0] + origin;
      const auto above = std::upper_bound(length.begin(), length.end(), at);
      const int s = std::min(std::max(int(above - length.begin()) - 1, 0), kSlabs - 1);
      const double stretch = (length[size_t(s) + 1] - length[size_t(s)]) / step,
                   own = low + s * step + (at - length[size_t(s)]) / stretch;
      for (size_t k = 0; k < objects_; ++k)
        if (!charts_[k].bend.straight())
          rates[size_t(i)] +=
              slab[size_t(s)][k] * charts_[k].bend.at(own).rate * (pose.chart.scale[0] / stretch);
    }
    const Vec3d middle =
        pose.chart.center + pose.chart.axes * (pose.chart.scale[0] * pose.chart.bend.middle());
    pose.chart.bend = Bend(pose.chart.bend.half(), std::move(rates));
    pose.chart.center = middle - pose.chart.axes * (pose.chart.scale[0] * pose.chart.bend.middle());
  }
  tbb::parallel_for(size_t(0), pose.at.size(), [&](size_t i) {
    Vec3d scale(0.0);
    for (size_t k = 0; k < objects_; ++k) scale += double(local[i * objects_ + k]) * charts_[k].scale;
    Vec3d& q = pose.at[i];
    q = Vec3d((lengthAt(q[0]) - origin) / pose.chart.scale[0], q[1] * scale[1] / pose.chart.scale[1],
              q[2] * scale[2] / pose.chart.scale[2]);
  });
}

/// Without chart and world.
MovingLattice::Pose MovingLattice::blend(const Weights& weights, const NodeWeights& local,
                                         const VectorField& offsets) const {
  Pose pose;
  pose.mean = weights;
  pose.at.resize(lattice_.count());
  pose.distance.resize(lattice_.count());
  tbb::parallel_for(0, int(lattice_.size[2]), [&](int z) {
    Weights own = weights, path = pathWeights(weights);
    for (int y = 0; y < lattice_.size[1]; ++y)
      for (int x = 0; x < lattice_.size[0]; ++x) {
        const size_t i = lattice_.index(x, y, z);
        if (!local.empty()) {
          own.assign(&local[i * objects_], &local[i * objects_] + objects_);
          path = pathWeights(own);
        }
        double rest = 1;  // of the node's own place in the middle space
        for (double w : path) rest -= w;
        Vec3d q = rest * lattice_.position(x, y, z);
        float d = 0;
        for (size_t k = 0; k < objects_; ++k) {
          q += path[k] * Vec3d(chart_[k][i]);
          if (own[k] != 0) d += float(own[k]) * distance_[k][i];
        }
        if (!offsets.empty()) q += Vec3d(offsets[i]);
        pose.at[i] = q, pose.distance[i] = d;
      }
  });
  return pose;
}

/// Of the lattice's nodes from the middle space.
VectorField MovingLattice::displacementOf(const Pose& pose) const {
  VectorField displacement(lattice_.count());
  tbb::parallel_for(0, int(lattice_.size[2]), [&](int z) {
    for (int y = 0; y < lattice_.size[1]; ++y)
      for (int x = 0; x < lattice_.size[0]; ++x) {
        const size_t i = lattice_.index(x, y, z);
        displacement[i] = openvdb::Vec3s(pose.at[i] - lattice_.position(x, y, z));
      }
  });
  return displacement;
}

std::vector<Vec3d> MovingLattice::carryPoints(const std::vector<Vec3d>& points, const Pose& from,
                                              const Pose& to) const {
  const VectorField here = displacementOf(from), there = displacementOf(to);
  const MiddleGuess guess(lattice_, here);
  std::vector<Vec3d> result(points.size());
  tbb::parallel_for(size_t(0), points.size(), [&](size_t i) {
    const Vec3d a = from.chart.toChart(points[i]), start = guess.near(a);
    Vec3d s = start;
    if (!toMiddleContinued(lattice_, here, a, s)) s = start;  // where the map has a fold
    result[i] = to.chart.toWorld(s + sampleContinued(lattice_, there, s));
  });
  return result;
}

/// World centroid of the inside, cell by cell: each cell's volume in the world by the share of it that is
/// inside.
Vec3d MovingLattice::centroid(const Pose& pose, const Chart& chart) const {
  std::vector<Vec3d> world(pose.at.size());
  tbb::parallel_for(size_t(0), world.size(), [&](size_t i) { world[i] = chart.toWorld(pose.at[i]); });
  std::vector<Vec3d> sums(lattice_.size[2], Vec3d(0.0));
  std::vector<double> volumes(lattice_.size[2], 0);
  tbb::parallel_for(0, int(lattice_.size[2]) - 1, [&](int z) {
    for (int y = 0; y + 1 < lattice_.size[1]; ++y)
      for (int x = 0; x + 1 < lattice_.size[0]; ++x) {
        Vec3d p[8], middle(0.0);
        float d = 0;
        for (int c = 0; c < 8; ++c) {
          const size_t i = lattice_.index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
          p[c] = world[i];
          middle += p[c] / 8.0, d += pose.distance[i] / 8;
        }
        double share = std::min(std::max(0.5 - d / lattice_.spacing, 0.0), 1.0);
        if (share == 0) continue;
        double volume = 0;
        for (const auto& t : kKuhnTetrahedra) volume += volumeOf(p, t);
        if (!(volume > 0)) continue;
        sums[z] += share * volume * middle, volumes[z] += share * volume;
      }
  });
  Vec3d sum(0.0);
  double volume = 0;
  for (size_t z = 0; z < sums.size(); ++z) sum += sums[z], volume += volumes[z];
  return volume > 0 ? sum / volume : chart.center;
}

/// One in-between's lattice in a frame's index space, and what is to be found between its nodes.
struct MovingLattice::Frame {
  const Pose& pose;
  std::vector<const VectorField*> fields;
  std::vector<Vec3d> node;  ///< in units of `step` voxels
  std::vector<char> near;   ///< per cell (at its first node): to be looked at
  NodeMap* map;
  double handed = 1;  ///< -1: the frame's index space is mirrored, and so is every tetrahedron
};

/// Grid nodes found in one slab's tetrahedra.
struct MovingLattice::Found {
  std::vector<size_t> node;
  std::vector<float> distance;     ///< blended, chart units
  std::vector<openvdb::Vec3s> at;  ///< per node and field
};

MovingLattice::Frame MovingLattice::frameOf(const Pose& pose, const openvdb::math::Transform& transform,
                                            std::vector<const VectorField*> fields, NodeMap& map) const {
  map.objects = fields.size();
  Frame frame{pose, std::move(fields), std::vector<Vec3d>(lattice_.count()),
              std::vector<char>(lattice_.count(), 0), &map};
  frame.handed = transform.baseMap()->getAffineMap()->getMat4().det() < 0 ? -1 : 1;
  tbb::parallel_for(size_t(0), frame.node.size(),
                    [&](size_t i) { frame.node[i] = transform.worldToIndex(pose.world[i]) / map.step; });
  return frame;
}

std::vector<const VectorField*> MovingLattice::places() const {
  std::vector<const VectorField*> fields;
  for (const VectorField& field : place_) fields.push_back(&field);
  return fields;
}

std::vector<double> MovingLattice::jumps(const Chart& chart, const openvdb::math::Transform& transform,
                                         int step) const {
  std::vector<double> jumps;
  if (chart.bend.straight()) return jumps;
  for (const Chart& c : charts_)
    jumps.push_back(kStretch * step * transform.voxelSize()[0] * c.meanScale() / chart.meanScale());
  return jumps;
}

NodeMap MovingLattice::nodesNearSurface(const Pose& pose, const openvdb::math::Transform& transform,
                                        int step) const {
  NodeMap map;
  map.step = step;
  map.jump = jumps(pose.chart, transform, step);
  Frame frame = frameOf(pose, transform, places(), map);
  // Nodes are needed as far out as the band, and two nodes more for the splines between them.
  const double voxel = transform.voxelSize()[0] / pose.chart.meanScale();
  const float reach = float((kHalfWidth + 2 * step * std::sqrt(3.0)) * voxel);
  std::vector<openvdb::BBoxd> boxes(lattice_.size[2]);
  std::vector<size_t> crossed(lattice_.size[2], 0), folded(lattice_.size[2], 0);
  tbb::parallel_for(0, int(lattice_.size[2]) - 1, [&](int z) {
    for (int y = 0; y + 1 < lattice_.size[1]; ++y)
      for (int x = 0; x + 1 < lattice_.size[0]; ++x) {
        float low = 1e30f, high = -1e30f;
        size_t corner[8];
        for (int c = 0; c < 8; ++c) {
          corner[c] = lattice_.index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
          low = std::min(low, pose.distance[corner[c]]), high = std::max(high, pose.distance[corner[c]]);
        }
        if (low > reach || high < -reach) continue;
        frame.near[corner[0]] = 1;
        for (size_t i : corner) boxes[z].expand(frame.node[i]);
        if (low > 0 || high < 0) continue;
        ++crossed[z];
        Vec3d q[8], a[8];
        for (int c = 0; c < 8; ++c) q[c] = pose.at[corner[c]];
        bool folds = false;
        for (size_t k = 0; k < objects_ && !folds; ++k) {
          for (int c = 0; c < 8; ++c) a[c] = Vec3d(chart_[k][corner[c]]);
          for (const auto& t : kKuhnTetrahedra) {
            const double vq = volumeOf(q, t), va = volumeOf(a, t);
            folds |= !(vq > 0) || !(va > kFoldedBelow * vq);
          }
        }
        folded[z] += folds;
      }
  });
  openvdb::BBoxd box;
  size_t allCrossed = 0, allFolded = 0;
  for (int z = 0; z < lattice_.size[2]; ++z) {
    if (!boxes[z].empty()) box.expand(boxes[z]);
    allCrossed += crossed[z], allFolded += folded[z];
  }
  map.foldShare = allCrossed ? double(allFolded) / double(allCrossed) : 0;
  if (allCrossed == 0) return map;
  // The lattice's margin is a share of the objects' size; voxels may be so large that the band's cells stand
  // out of it.
  const bool ends = endsWithin(float((kHalfWidth + kSteepest * step * std::sqrt(3.0)) * voxel), pose);
  if (ends) {
    const Vec3d nodes(reach / (voxel * step));
    box = openvdb::BBoxd(box.min() - nodes, box.max() + nodes);
  }
  map.origin = openvdb::Coord::floor(box.min());
  map.size = openvdb::Coord::ceil(box.max()) - map.origin + openvdb::Coord(1);
  findNodes(frame, map);
  if (ends) continueBeyond(pose, transform, reach, map);
  return map;
}

/// Whether an outermost node of the lattice is nearer to the surface than a distance in chart units.
bool MovingLattice::endsWithin(float distance, const Pose& pose) const {
  for (int z = 0; z < lattice_.size[2]; ++z)
    for (int y = 0; y < lattice_.size[1]; ++y) {
      const bool whole = z == 0 || y == 0 || z == lattice_.size[2] - 1 || y == lattice_.size[1] - 1;
      for (int x = 0; x < lattice_.size[0]; x += whole ? 1 : lattice_.size[0] - 1)
        if (pose.distance[lattice_.index(x, y, z)] < distance) return true;
    }
  return false;
}

/// Finds the nodes beyond the lattice, where its outermost nodes' displacements go on. `reach`: chart units.
void MovingLattice::continueBeyond(const Pose& pose, const openvdb::math::Transform& transform, float reach,
                                   NodeMap& map) const {
  const VectorField displacement = displacementOf(pose);
  const openvdb::Coord end = lattice_.size - openvdb::Coord(1);
  const Vec3d first = lattice_.origin, last = lattice_.position(end[0], end[1], end[2]);
  // The outermost cells are looked at, too: their tetrahedra end a little elsewhere than the trilinear field.
  const openvdb::BBoxd inner(first + Vec3d(lattice_.spacing), last - Vec3d(lattice_.spacing));
  forUnknownNodes(map, pose.chart, transform, [&](const Vec3d& q, size_t n) {
    Vec3d s = q;
    if (!toMiddleContinued(lattice_, displacement, q, s) || inner.isInside(s)) return;
    const Vec3d border = openvdb::math::minComponent(openvdb::math::maxComponent(s, first), last);
    // The objects lie within the lattice: what is far from them at its border is further out here.
    const openvdb::Coord nearest = openvdb::Coord::round((border - first) / lattice_.spacing);
    if (pose.distance[lattice_.index(nearest[0], nearest[1], nearest[2])] > reach + lattice_.spacing) return;
    bool crossed = false;
    for (size_t k = 0; k < objects_; ++k) {
      const Vec3d a = sampleContinued(lattice_, chart_[k], border) + s - border;
      crossed |= charts_[k].spread(a) <= 0;
      map.at[n * objects_ + k] = openvdb::Vec3s(charts_[k].toWorld(a) - anchor_[k]);
    }
    map.known[n] = !crossed;
  });
}

openvdb::BBoxd MovingLattice::boxOf(size_t object, const openvdb::BBoxd& world, const Pose& pose,
                                    const openvdb::math::Transform& transform) const {
  openvdb::BBoxd box;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at(world.min()[0] + (corner & 1) * world.extents()[0],
                   world.min()[1] + (corner >> 1 & 1) * world.extents()[1],
                   world.min()[2] + (corner >> 2) * world.extents()[2]);
    box.expand(transform.worldToIndex(pose.chart.toWorld(charts_[object].toChart(at))));
  }
  // Nodes within a cell of it, too: what lies between nodes may reach as far.
  const Vec3d cell(lattice_.spacing * charts_[object].meanScale());
  const openvdb::BBoxd wide(world.min() - cell, world.max() + cell);
  for (size_t i = 0; i < lattice_.count(); ++i)
    if (wide.isInside(anchor_[object] + Vec3d(place_[object][i])))
      box.expand(transform.worldToIndex(pose.world[i]));
  return box;
}

NodeMap MovingLattice::nodesWithin(const openvdb::CoordBBox& box, const Pose& pose,
                                   const openvdb::math::Transform& transform, int step) const {
  NodeMap map;
  map.step = step;
  map.jump = jumps(pose.chart, transform, step);
  fillBox(
      box, frameOf(pose, transform, places(), map), transform,
      [&](const Vec3d& q, size_t k) { return openvdb::Vec3s(charts_[k].toWorld(q) - anchor_[k]); }, map);
  return map;
}

NodeMap MovingLattice::velocitiesWithin(const openvdb::CoordBBox& box, const Weights& weights,
                                        const Weights& rate, const Pose& pose,
                                        const openvdb::math::Transform& transform, int step) const {
  // Central differences: the map goes on a little beyond the objects.
  double most = 0;
  for (double r : rate) most = std::max(most, std::abs(r));
  const double time = most > 0 ? kWeightStep / most : 0, unit = time > 0 ? 0.5 / time : 0;
  Weights earlier = weights, later = weights;
  for (size_t k = 0; k < objects_; ++k) earlier[k] -= time * rate[k], later[k] += time * rate[k];
  const Pose from = poseAt(earlier, pose.straightening), to = poseAt(later, pose.straightening);
  VectorField velocity(lattice_.count());
  tbb::parallel_for(size_t(0), velocity.size(),
                    [&](size_t i) { velocity[i] = openvdb::Vec3s(unit * (to.world[i] - from.world[i])); });
  NodeMap map;
  map.step = step;
  const auto beyond = [&](const Vec3d& q, size_t) {
    return openvdb::Vec3s(unit * (to.chart.toWorld(q) - from.chart.toWorld(q)));
  };
  fillBox(box, frameOf(pose, transform, {&velocity}, map), transform, beyond, map);
  return map;
}

void MovingLattice::fillBox(const openvdb::CoordBBox& box, Frame frame,
                            const openvdb::math::Transform& transform, const Beyond& beyond,
                            NodeMap& map) const {
  std::fill(frame.near.begin(), frame.near.end(), 1);
  // One node more on every side, for the splines.
  map.origin = openvdb::Coord::floor(box.min().asVec3d() / map.step) - openvdb::Coord(1);
  map.size = openvdb::Coord::ceil(box.max().asVec3d() / map.step) + openvdb::Coord(2) - map.origin;
  findNodes(frame, map);
  forUnknownNodes(map, frame.pose.chart, transform, [&](const Vec3d& q, size_t n) {
    for (size_t f = 0; f < map.objects; ++f) map.at[n * map.objects + f] = beyond(q, f);
    map.known[n] = 1;
  });
}

void MovingLattice::findNodes(const Frame& frame, NodeMap& map) const {
  const size_t nodes = size_t(map.size[0]) * map.size[1] * map.size[2];
  map.at.resize(nodes * map.objects);
  map.known.assign(nodes, 0);
  std::vector<Found> found(lattice_.size[2]);
  tbb::parallel_for(0, int(lattice_.size[2]) - 1, [&](int z) { rasterise(frame, z, found[z]); });
  // Where slices of a bent chart cross, a node is found more than once: what is nearer to the object wins.
  std::vector<float> nearest(nodes, kNothing);
  for (const Found& f : found)
    for (size_t i = 0; i < f.node.size(); ++i) {
      const size_t n = f.node[i];
      if (!(f.distance[i] < nearest[n])) continue;
      nearest[n] = f.distance[i];
      map.known[n] = 1;
      std::copy_n(&f.at[i * map.objects], map.objects, &map.at[n * map.objects]);
    }
}

/// Finds the nodes inside every near tetrahedron of one slab, with the fields there by barycentric
/// coordinates.
void MovingLattice::rasterise(const Frame& frame, int z, Found& found) const {
  for (int y = 0; y + 1 < lattice_.size[1]; ++y)
    for (int x = 0; x + 1 < lattice_.size[0]; ++x) {
      if (!frame.near[lattice_.index(x, y, z)]) continue;
      size_t corner[8];
      Vec3d p[8], cellLow(1e30), cellHigh(-1e30);
      for (int c = 0; c < 8; ++c) {
        corner[c] = lattice_.index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
        p[c] = frame.node[corner[c]];
        for (int a = 0; a < 3; ++a)
          cellLow[a] = std::min(cellLow[a], p[c][a]), cellHigh[a] = std::max(cellHigh[a], p[c][a]);
      }
      openvdb::Coord low = openvdb::Coord::ceil(cellLow - Vec3d(kOnFace));
      openvdb::Coord high = openvdb::Coord::floor(cellHigh + Vec3d(kOnFace));
      low.maxComponent(frame.map->origin);
      high.minComponent(frame.map->origin + frame.map->size - openvdb::Coord(1));
      if (low[0] > high[0] || low[1] > high[1] || low[2] > high[2]) continue;
      for (const auto& t : kKuhnTetrahedra) {
        const Vec3d e1 = p[t[1]] - p[t[0]], e2 = p[t[2]] - p[t[0]], e3 = p[t[3]] - p[t[0]];
        const double volume = e1.cross(e2).dot(e3);
        if (!(frame.handed * volume > 0)) continue;
        const Vec3d n1 = e2.cross(e3) / volume, n2 = e3.cross(e1) / volume, n3 = e1.cross(e2) / volume;
        for (int k = low[2]; k <= high[2]; ++k)
          for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i) {
              const Vec3d d = Vec3d(i, j, k) - p[t[0]];
              const double b1 = n1.dot(d), b2 = n2.dot(d), b3 = n3.dot(d), b0 = 1 - b1 - b2 - b3;
              if (b0 < -kOnFace || b1 < -kOnFace || b2 < -kOnFace || b3 < -kOnFace) continue;
              found.node.push_back(frame.map->index(i, j, k));
              const std::vector<float>& f = frame.pose.distance;
              found.distance.push_back(float(b0 * f[corner[t[0]]] + b1 * f[corner[t[1]]] +
                                             b2 * f[corner[t[2]]] + b3 * f[corner[t[3]]]));
              for (const VectorField* field : frame.fields) {
                const VectorField& a = *field;
                found.at.push_back(openvdb::Vec3s(b0 * Vec3d(a[corner[t[0]]]) + b1 * Vec3d(a[corner[t[1]]]) +
                                                  b2 * Vec3d(a[corner[t[2]]]) + b3 * Vec3d(a[corner[t[3]]])));
              }
            }
      }
    }
}

}  // namespace slicemorph

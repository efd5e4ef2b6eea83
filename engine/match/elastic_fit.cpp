#include "engine/match/elastic_fit.h"

#include "engine/numerics/conjugate_gradients.h"
#include "engine/numerics/nearest_rotation.h"
#include "engine/numerics/smoothstep.h"
#include "engine/spine/chart.h"

#include <Eigen/Core>

#include <nanoflann.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace slicemorph {

namespace {

/// Stiffness against one per sample, from stage to stage, and how far partners may be then, in sizes of the
/// target (root mean square distance from its middle). Measured on the recorded motions samba and horse_collapse
/// with known correspondence: .7 and 1.5 % of the diagonal in the mean.
struct Stage {
  double stiffness, reach;
  double
      hopeless;  ///< a fit whose residual is more than this many times the limit is given up after it; 0: never
};
constexpr Stage kStages[] = {{30, 0.9, 1.2}, {10, 0.6, 1}, {3, 0.45, 1}, {1, 0.3, 0}, {0.3, 0.24, 0}};
constexpr int kPartnerSteps = 20;  ///< per stage, at most: new partners are looked for
/// A stage is over once nodes move by less than this many spacings in a step (root mean square). With .01 the match of
/// the recorded motion horse_collapse gets worse (from 1.5 to 1.65 % of the diagonal), with .005 not.
constexpr double kAtRest = 0.005;
constexpr int kFirstRotations = 5;  ///< rounds by which rotations are found that a start does not tell
constexpr int kRounds = 2;          ///< per step: rotations, then positions
constexpr int kLinearSteps = 30;    ///< of conjugate gradients per round; the next round goes on from there
constexpr double kSameSide = 0.7;   ///< least cosine between partners' normals
constexpr size_t kCandidates = 8;   ///< nearest points among which partners are looked for
constexpr float kSliding = 0.02f;   ///< weight of distances along the plane against those to it
constexpr double kLikeNeighbours =
    0.5;  ///< weight of neighbours' rotations against the edges' own directions
/// How far around a sample areas are compared, in sizes of the target, and up to which ratio they are alike.
constexpr double kAround = 0.15, kMostRatio = 1.8;
/// Share of a body's change that is no rotation (root of squares) up to which it is taken as turned, and from which as
/// crumpled: where as much is strain as is turned, .71, rotations tell nothing of the way. It is .25 on the recorded motion
/// samba and .83 on horse_collapse. Half way they are off by .925 and .641 % of the diagonal; decided node by node by strain
/// (.2 to .5) .926 and .649 %, by this share .923 and .656 %.
constexpr double kTurned = 0.5, kCrumpled = 0.8;
constexpr float kHold = 1e-6f;  ///< keeps nodes that nothing else holds where they are

using Four = Eigen::Array4f;
using Columns = std::vector<float>;  // kStride numbers per node: three, and a zero that fills up a register
constexpr size_t kStride = 4;

Four fourOf(const Columns& x, int node) { return Four::Map(&x[kStride * size_t(node)]); }
void addTo(Columns& x, int node, const Four& more) {
  Four::MapType at(&x[kStride * size_t(node)]);
  at += more;
}

/// Points for a search of the nearest ones.
struct PointSet {
  const std::vector<Vec3d>& points;
  size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(size_t i, size_t axis) const { return points[i][int(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

class NearestPoints {
 public:
  /// `spacing`: between neighbouring points, about.
  explicit NearestPoints(const std::vector<Vec3d>& points, double spacing = 0)
      : set_{points}, spacing_(spacing), tree_(3, set_, nanoflann::KDTreeSingleIndexAdaptorParams(12)) {
    tree_.buildIndex();
  }

  /// The nearest of a few points that looks the same way as `normal`; none: the number of points.
  size_t facing(const Vec3d& p, const Vec3d& normal, const std::vector<Vec3d>& normals, double reach) const {
    std::uint32_t index[kCandidates];
    double squared[kCandidates];
    // Mostly the nearest one does already, and is found much sooner than several.
    for (size_t candidates : {size_t(1), kCandidates}) {
      const size_t found = tree_.knnSearch(p.asPointer(), candidates, index, squared);
      for (size_t i = 0; i < found && squared[i] < reach * reach; ++i)
        if (normals[index[i]].dot(normal) > kSameSide) return index[i];
    }
    return set_.points.size();
  }

  /// Share of the points that are within `radius` and do not look the other way than `normal`.
  double shareAround(const Vec3d& p, const Vec3d& normal, const std::vector<Vec3d>& normals,
                     double radius) const {
    std::vector<std::pair<std::uint32_t, double>> found;
    tree_.radiusSearch(p.asPointer(), radius * radius, found, nanoflann::SearchParams(0, 0, false));
    size_t facing = 0;
    for (const auto& [index, squared] : found) facing += normals[index].dot(normal) > 0;
    return double(facing) / double(set_.points.size());
  }

  /// From the plane of the nearest point, whose normal is one of `normals`.
  double toPlane(const Vec3d& p, const std::vector<Vec3d>& normals) const {
    std::uint32_t index = 0;
    double squared = 0;
    tree_.knnSearch(p.asPointer(), 1, &index, &squared);
    const double distance = std::sqrt(squared);
    // Far off it is the distance that counts.
    return std::max(std::abs(normals[index].dot(p - set_.points[index])), distance - spacing_);
  }

 private:
  PointSet set_;
  double spacing_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointSet>, PointSet, 3> tree_;
};

/// What draws one sample: sum of weight * (n n^T + sliding) over its partners, and that times their positions.
struct Pull {
  Four column[3] = {Four::Zero(), Four::Zero(), Four::Zero()};  ///< of the matrix
  double vector[3] = {};

  void toPlane(const Vec3d& at, const Vec3d& normal) {
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        const double m = normal[r] * normal[c] + (r == c ? double(kSliding) : 0);
        column[c][r] += float(m), vector[r] += m * at[c];
      }
  }
};

/// The equations of all nodes' positions, as conjugateGradients wants them.
class BodySystem {
 public:
  BodySystem(const BodyGraph& graph, const BoundPoints& points, const std::vector<Pull>& pulls,
             float stiffness)
      : graph_(graph), points_(points), pulls_(pulls), stiffness_(stiffness), diagonal_(size(), kHold) {
    for (const BodyGraph::Edge& e : graph_.edges)
      for (int node : {e.from, e.to}) addTo(diagonal_, node, Four(stiffness_ * e.weight));
    for (size_t i = 0; i < pulls_.size(); ++i)
      for (int k = 0; k < BodyGraph::Binding::kNodes; ++k) {
        const BodyGraph::Binding& b = points_.binding[i];
        for (int c = 0; c < 3; ++c)
          diagonal_[kStride * size_t(b.node[k]) + size_t(c)] +=
              b.weight[k] * b.weight[k] * pulls_[i].column[c][c];
      }
  }

  size_t size() const { return kStride * graph_.position.size(); }
  size_t node(size_t i) const { return i; }
  float diagonal(size_t i) const { return diagonal_[i]; }
  Grain grain() const { return {std::numeric_limits<size_t>::max()}; }

  void apply(const Columns& x, Columns& y) const {
    for (size_t i = 0; i < y.size(); ++i) y[i] = kHold * x[i];
    for (const BodyGraph::Edge& e : graph_.edges) {
      const Four difference = (stiffness_ * e.weight) * (fourOf(x, e.from) - fourOf(x, e.to));
      addTo(y, e.from, difference), addTo(y, e.to, -difference);
    }
    for (size_t i = 0; i < pulls_.size(); ++i) {
      const BodyGraph::Binding& b = points_.binding[i];
      Four p = Four::Zero();
      for (int k = 0; k < BodyGraph::Binding::kNodes; ++k) p += b.weight[k] * fourOf(x, b.node[k]);
      const Pull& pull = pulls_[i];
      const Four f = pull.column[0] * p[0] + pull.column[1] * p[1] + pull.column[2] * p[2];
      for (int k = 0; k < BodyGraph::Binding::kNodes; ++k) addTo(y, b.node[k], b.weight[k] * f);
    }
  }

 private:
  const BodyGraph& graph_;
  const BoundPoints& points_;
  const std::vector<Pull>& pulls_;
  float stiffness_;
  std::vector<float> diagonal_;
};

/// Solves for positions whose edges are to be `wanted`. `pulls`: none to draw no sample.
void solvePositions(const BodyGraph& graph, const BoundPoints& points, const std::vector<Pull>& pulls,
                    const std::vector<Vec3d>& turned, const std::vector<Vec3d>& wanted, float stiffness,
                    const GradientSettings& settings, std::vector<Vec3d>& position) {
  BodySystem system(graph, points, pulls, stiffness);
  Columns x(system.size(), 0.f), residual(system.size());
  // Positions relative to a node: single precision is then enough for objects far off.
  const Vec3d origin = position[0];
  for (size_t i = 0; i < position.size(); ++i)
    for (size_t c = 0; c < 3; ++c) x[kStride * i + c] = float(position[i][int(c)] - origin[int(c)]);
  system.apply(x, residual);
  std::vector<double> right(system.size());
  const auto rightOf = [&](int node, int c) -> double& { return right[kStride * size_t(node) + size_t(c)]; };
  for (size_t i = 0; i < right.size(); ++i) right[i] = double(kHold) * x[i];
  for (size_t e = 0; e < graph.edges.size(); ++e)
    for (int c = 0; c < 3; ++c) {
      const double f = double(stiffness) * graph.edges[e].weight * wanted[e][c];
      rightOf(graph.edges[e].to, c) += f, rightOf(graph.edges[e].from, c) -= f;
    }
  for (size_t i = 0; i < pulls.size(); ++i) {
    // Drawn is the sample, which is `turned` away from its nodes' mean.
    const Pull& pull = pulls[i];
    double f[3];
    for (int r = 0; r < 3; ++r) {
      f[r] = pull.vector[r];
      for (int c = 0; c < 3; ++c) f[r] -= double(pull.column[c][r]) * (turned[i][c] + origin[c]);
    }
    const BodyGraph::Binding& b = points.binding[i];
    for (int k = 0; k < BodyGraph::Binding::kNodes; ++k)
      for (int c = 0; c < 3; ++c) rightOf(b.node[k], c) += double(b.weight[k]) * f[c];
  }
  for (size_t i = 0; i < residual.size(); ++i) residual[i] = float(right[i] - double(residual[i]));
  conjugateGradients<float>(system, settings, std::move(residual), x);
  for (size_t i = 0; i < position.size(); ++i)
    for (size_t c = 0; c < 3; ++c) position[i][int(c)] = origin[int(c)] + double(x[kStride * i + c]);
}

std::vector<Vec3d> offsetsOf(const BodyGraph& graph, const BoundPoints& points,
                             const std::vector<Mat3d>& rotation) {
  std::vector<Vec3d> offsets(points.own.size(), Vec3d(0.0));
  for (size_t i = 0; i < offsets.size(); ++i)
    for (int k = 0; k < BodyGraph::Binding::kNodes; ++k) {
      const size_t node = size_t(points.binding[i].node[k]);
      offsets[i] +=
          double(points.binding[i].weight[k]) * (rotation[node] * (points.own[i] - graph.position[node]));
    }
  return offsets;
}

/// Every node's rotation by how its edges are turned, and by its neighbours' rotations.
std::vector<Mat3d> fittedRotations(const BodyGraph& graph, const ElasticFit& fit) {
  std::vector<Mat3d> sums(graph.position.size(), Mat3d::zero());
  for (const BodyGraph::Edge& e : graph.edges) {
    const size_t a = size_t(e.from), b = size_t(e.to);
    const Vec3d before = graph.position[b] - graph.position[a], after = fit.position[b] - fit.position[a];
    addOuter(sums[a], double(e.weight), after, before), addOuter(sums[b], double(e.weight), after, before);
    const double like = kLikeNeighbours * double(e.weight) * before.lengthSqr();
    sums[a] += like * fit.rotation[b], sums[b] += like * fit.rotation[a];
  }
  std::vector<Mat3d> rotations(sums.size());
  for (size_t i = 0; i < sums.size(); ++i)
    rotations[i] = graph.neighbours[i].empty() ? fit.rotation[i] : nearestRotation(sums[i], fit.rotation[i]);
  return rotations;
}

/// What the edges would be if nothing but rotations changed them.
std::vector<Vec3d> rotatedEdges(const BodyGraph& graph, const std::vector<Mat3d>& rotation) {
  std::vector<Vec3d> wanted;
  for (const BodyGraph::Edge& e : graph.edges) {
    const Vec3d before = graph.position[size_t(e.to)] - graph.position[size_t(e.from)];
    wanted.push_back(0.5 * (rotation[size_t(e.from)] * before + rotation[size_t(e.to)] * before));
  }
  return wanted;
}

Vec3d meanOf(const std::vector<Vec3d>& points) {
  Vec3d mean(0.0);
  for (const Vec3d& p : points) mean += p / double(points.size());
  return mean;
}

double sizeOf(const std::vector<Vec3d>& points) {
  const Vec3d middle = meanOf(points);
  double sum = 0;
  for (const Vec3d& p : points) sum += (p - middle).lengthSqr() / double(points.size());
  return std::sqrt(sum);
}

/// Root mean square of the distances between points that belong together.
double distanceOf(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).lengthSqr() / double(a.size());
  return std::sqrt(sum);
}

/// The planes that draw each sample of `surface`, which is now at `at` with normals `normal`.
std::vector<Pull> pullsOn(const std::vector<Vec3d>& at, const std::vector<Vec3d>& normal,
                          const OrientedPoints& target, const NearestPoints& nearTarget, double reach) {
  std::vector<Pull> pulls(at.size());
  for (size_t i = 0; i < at.size(); ++i)
    if (const size_t j = nearTarget.facing(at[i], normal[i], target.normal, reach);
        j < target.position.size())
      pulls[i].toPlane(target.position[j], target.normal[j]);
  const NearestPoints nearSurface(at);
  for (size_t j = 0; j < target.position.size(); ++j)
    if (const size_t i = nearSurface.facing(target.position[j], target.normal[j], normal, reach);
        i < at.size())
      pulls[i].toPlane(target.position[j], target.normal[j]);
  return pulls;
}

std::vector<Vec3d> turnedNormals(const OrientedPoints& surface, const BoundPoints& points,
                                 const std::vector<Mat3d>& rotation) {
  std::vector<Vec3d> normals;
  for (size_t i = 0; i < surface.normal.size(); ++i)
    normals.push_back(rotation[size_t(points.binding[i].node[0])] * surface.normal[i]);
  return normals;
}

/// Per edge, by how much a fit changes it beyond its rotation: squared, relative to its length, times its weight.
std::vector<double> edgeStrains(const BodyGraph& graph, const ElasticFit& fit) {
  const std::vector<Vec3d> wanted = rotatedEdges(graph, fit.rotation);
  std::vector<double> strain;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const BodyGraph::Edge& edge = graph.edges[e];
    const Vec3d after = fit.position[size_t(edge.to)] - fit.position[size_t(edge.from)];
    const double before = (graph.position[size_t(edge.to)] - graph.position[size_t(edge.from)]).lengthSqr();
    strain.push_back(double(edge.weight) * (after - wanted[e]).lengthSqr() / before);
  }
  return strain;
}

double strainOf(const BodyGraph& graph, const ElasticFit& fit) {
  double sum = 0, weights = 0;
  for (double strain : edgeStrains(graph, fit)) sum += strain;
  for (const BodyGraph::Edge& edge : graph.edges) weights += double(edge.weight);
  return weights > 0 ? std::sqrt(sum / weights) : 0;
}

/// Both surfaces on each other as a fit has them: the one where it was carried to, and the target.
class FittedSurfaces {
 public:
  FittedSurfaces(const BodyGraph& graph, const OrientedPoints& surface, const BoundPoints& points,
                 const OrientedPoints& target, const ElasticFit& fit)
      : at_(carried(graph, points, fit.position, fit.rotation)),
        normals_(turnedNormals(surface, points, fit.rotation)),
        target_(target),
        size_(sizeOf(target.position)),
        nearSurface_(at_, graph.spacing),
        nearTarget_(target.position, graph.spacing) {}

  double residual() const {
    return residualTo(at_, nearTarget_, target_.normal) +
           residualTo(target_.position, nearSurface_, normals_);
  }
  double missed() const {
    return missedAround(at_, normals_, nearSurface_, nearTarget_, target_.normal) +
           missedAround(target_.position, target_.normal, nearTarget_, nearSurface_, normals_);
  }

 private:
  double residualTo(const std::vector<Vec3d>& from, const NearestPoints& to,
                    const std::vector<Vec3d>& toNormals) const {
    double sum = 0;
    for (const Vec3d& p : from) sum += to.toPlane(p, toNormals);
    return 0.5 * sum / (double(from.size()) * size_);
  }

  double missedAround(const std::vector<Vec3d>& from, const std::vector<Vec3d>& fromNormals,
                      const NearestPoints& own, const NearestPoints& to,
                      const std::vector<Vec3d>& toNormals) const {
    size_t missed = 0;
    for (size_t i = 0; i < from.size(); ++i) {
      const double here = own.shareAround(from[i], fromNormals[i], fromNormals, kAround * size_),
                   there = to.shareAround(from[i], fromNormals[i], toNormals, kAround * size_);
      missed += here > kMostRatio * there || there > kMostRatio * here;
    }
    return 0.5 * double(missed) / double(from.size());
  }

  std::vector<Vec3d> at_, normals_;
  const OrientedPoints& target_;
  double size_;
  NearestPoints nearSurface_, nearTarget_;
};

/// Rotation vectors of the nodes, each in the turn (of those that differ by whole ones) nearest to the one of
/// the neighbour that it was reached from; begun at the node that is turned least.
std::vector<Vec3d> consistentVectors(const BodyGraph& graph, const std::vector<Mat3d>& rotation) {
  const size_t n = rotation.size();
  std::vector<Vec3d> vectors;
  for (const Mat3d& r : rotation) vectors.push_back(rotationVector(r));
  std::vector<size_t> order(n);
  for (size_t i = 0; i < n; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return vectors[a].lengthSqr() < vectors[b].lengthSqr(); });
  std::vector<char> seen(n, 0);
  for (size_t start : order) {
    if (seen[start]) continue;
    seen[start] = 1;
    std::queue<size_t> open;
    open.push(start);
    while (!open.empty()) {
      const size_t at = open.front();
      open.pop();
      for (int next : graph.neighbours[at]) {
        if (seen[size_t(next)]) continue;
        seen[size_t(next)] = 1;
        Vec3d& v = vectors[size_t(next)];
        const double angle = v.length();
        if (angle > 1e-6) {
          const Vec3d other = v * (1 - 2 * M_PI / angle);
          if ((other - vectors[at]).lengthSqr() < (v - vectors[at]).lengthSqr()) v = other;
        }
        open.push(size_t(next));
      }
    }
  }
  return vectors;
}

/// How far a fit's change is no rotation, 0 to 1: by what edges change beyond it against what they change in all.
double crumpledShare(const BodyGraph& graph, const ElasticFit& fit) {
  const std::vector<Vec3d> rotated = rotatedEdges(graph, fit.rotation);
  double beyond = 0, turned = 0;
  for (double strain : edgeStrains(graph, fit)) beyond += strain;
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    const BodyGraph::Edge& e = graph.edges[i];
    const Vec3d before = graph.position[size_t(e.to)] - graph.position[size_t(e.from)];
    turned += double(e.weight) * (rotated[i] - before).lengthSqr() / before.lengthSqr();
  }
  return beyond > 0 ? smoothstep(std::sqrt(beyond / (beyond + turned)), kTurned, kCrumpled) : 0;
}

}  // namespace

BoundPoints bindPoints(const BodyGraph& graph, const std::vector<Vec3d>& points) {
  BoundPoints bound{points, {}};
  for (const Vec3d& p : points) bound.binding.push_back(graph.bind(p));
  return bound;
}

std::vector<Vec3d> carried(const BodyGraph& graph, const BoundPoints& points,
                           const std::vector<Vec3d>& position, const std::vector<Mat3d>& rotation) {
  std::vector<Vec3d> at = offsetsOf(graph, points, rotation);
  for (size_t i = 0; i < at.size(); ++i)
    for (int k = 0; k < BodyGraph::Binding::kNodes; ++k)
      at[i] += double(points.binding[i].weight[k]) * position[size_t(points.binding[i].node[k])];
  return at;
}

ElasticFit fitElastically(const BodyGraph& graph, const OrientedPoints& surface, const OrientedPoints& target,
                          const BodyPose& start, double hopeless) {
  ElasticFit fit;
  fit.position = start.position, fit.rotation = start.rotation;
  const bool found = fit.rotation.empty();
  if (found) fit.rotation.assign(start.position.size(), Mat3d::identity());
  if (graph.position.empty() || surface.position.empty() || target.position.empty()) return fit;
  const BoundPoints points = bindPoints(graph, surface.position);
  const NearestPoints nearTarget(target.position);
  const double size = sizeOf(target.position);
  for (int i = 0; found && i < kFirstRotations; ++i) fit.rotation = fittedRotations(graph, fit);
  for (const Stage& stage : kStages) {
    double moved = std::numeric_limits<double>::max();
    for (int step = 0; step < kPartnerSteps && moved > kAtRest * graph.spacing; ++step) {
      const std::vector<Vec3d> before = fit.position;
      const std::vector<Pull> pulls =
          pullsOn(carried(graph, points, fit.position, fit.rotation),
                  turnedNormals(surface, points, fit.rotation), target, nearTarget, stage.reach * size);
      for (int round = 0; round < kRounds; ++round) {
        fit.rotation = fittedRotations(graph, fit);
        solvePositions(graph, points, pulls, offsetsOf(graph, points, fit.rotation),
                       rotatedEdges(graph, fit.rotation), float(stage.stiffness), {kLinearSteps, 1e-6},
                       fit.position);
      }
      moved = distanceOf(before, fit.position);
    }
    fit.rotation = fittedRotations(graph, fit);
    if (stage.hopeless == 0) continue;
    fit.hopeless = FittedSurfaces(graph, surface, points, target, fit).residual() > stage.hopeless * hopeless;
    if (fit.hopeless) return fit;
  }
  const FittedSurfaces fitted(graph, surface, points, target, fit);
  fit.strain = strainOf(graph, fit), fit.residual = fitted.residual(), fit.missed = fitted.missed();
  return fit;
}

ElasticFit partWay(const BodyGraph& graph, const ElasticFit& fit, double t) {
  ElasticFit part;
  std::vector<Mat3d> back;  // from the fit to the part of the way
  for (const Vec3d& v : consistentVectors(graph, fit.rotation))
    part.rotation.push_back(rotationFromVector(t * v)), back.push_back(rotationFromVector((t - 1) * v));
  const double straight = crumpledShare(graph, fit);
  // An edge's stretch is told by turning the fitted one back; both ends say how it is turned. A body that
  // is crumpled rather than turned goes straight.
  std::vector<Vec3d> wanted;
  for (const BodyGraph::Edge& e : graph.edges) {
    const size_t ends[2] = {size_t(e.from), size_t(e.to)};
    const Vec3d before = graph.position[ends[1]] - graph.position[ends[0]],
                after = fit.position[ends[1]] - fit.position[ends[0]];
    Vec3d edge(0.0);
    for (size_t node : ends)
      edge += 0.5 * ((1 - t) * (part.rotation[node] * before) + t * (back[node] * after));
    wanted.push_back(edge + straight * ((1 - t) * before + t * after - edge));
  }
  part.position.resize(graph.position.size());
  for (size_t i = 0; i < part.position.size(); ++i)
    part.position[i] = (1 - t) * graph.position[i] + t * fit.position[i];
  // Edges say nothing of where the whole lies.
  const Vec3d middle = meanOf(part.position);
  constexpr int kMostSteps = 2000;
  solvePositions(graph, {}, {}, {}, wanted, 1, {kMostSteps, 1e-10}, part.position);
  const Vec3d shift = middle - meanOf(part.position);
  for (Vec3d& p : part.position) p += shift;
  return part;
}

double largestTurn(const BodyGraph& graph, const ElasticFit& fit) {
  const std::vector<Vec3d> vectors = consistentVectors(graph, fit.rotation);
  Vec3d mean(0.0);
  for (const Vec3d& v : vectors) mean += v / double(vectors.size());
  std::vector<double> angles;
  for (const Vec3d& v : vectors) angles.push_back((v - mean).length());
  // A few nodes in a crease may be turned any way.
  const size_t rank = size_t(0.98 * double(angles.size() - 1));
  std::nth_element(angles.begin(), angles.begin() + std::ptrdiff_t(rank), angles.end());
  return angles[rank];
}

}  // namespace slicemorph

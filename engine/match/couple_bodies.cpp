#include "engine/match/couple_bodies.h"

#include "engine/numerics/nearest_rotation.h"
#include "engine/spine/inner_points.h"

#include <Eigen/Core>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace slicemorph {

namespace {

// Figures of the prototype of the method, which coupled animals, people and hands; more in elastic_fit.cpp, which goes
// on from here.

constexpr size_t kFew = 80, kMany = 160;  ///< points per body, for finding and for refining
/// Blurs of the couplings, of mean squared distances: the first one by position alone, then from wide to narrow.
constexpr double kStartBlur = 0.3;
struct Course {
  double from, to;
  int steps;
};
constexpr Course kFinding{0.15, 0.01, 20}, kRefining{0.03, 0.005, 15};
constexpr int kScalings = 20;
/// Prices of position and of differing fullness against inner distances.
constexpr double kPositionPrice = 0.2, kUnlikePrice = 0.05;
/// What the farthest tip counts against the body's middle where positions are compared: limbs swing.
constexpr double kTipCounts = 0.2;
/// Reach of the points by whose images a node is carried, in mean inner distances.
constexpr double kCarryReach = 0.25;
/// What a node's turn is drawn to its neighbours', against the size of the sum of outer products that tells it.
constexpr double kNoTwist = 0.2;

using Table = Eigen::ArrayXXd;
using Column = Eigen::ArrayXd;

/// One body's points.
struct Side {
  InnerPoints points;
  std::vector<Vec3d> at;  ///< about their mean, in root mean square radii
  Vec3d mean{0, 0, 0};
  double radius = 1;
  Table distance;
  Column weight, still;  ///< per point; still: how little it swings
};

Side sideOf(const BodyGraph& graph, InnerPoints points) {
  Side side;
  side.points = std::move(points);
  const InnerPoints& p = side.points;
  const size_t n = p.node.size();
  if (n == 0) return side;
  double squares = 0;
  for (size_t i = 0; i < n; ++i) side.mean += p.weight[i] * graph.position[p.node[i]];
  for (size_t i = 0; i < n; ++i)
    side.at.push_back(graph.position[p.node[i]] - side.mean), squares += p.weight[i] * side.at[i].lengthSqr();
  side.radius = std::sqrt(squares);
  for (Vec3d& x : side.at) x /= side.radius;
  side.distance.resize(Eigen::Index(n), Eigen::Index(n));
  side.weight.resize(Eigen::Index(n)), side.still.resize(Eigen::Index(n));
  double farthest = 0;
  for (size_t i = 0; i < n; ++i) farthest = std::max(farthest, p.toNodes[i][graph.deepest]);
  for (size_t i = 0; i < n; ++i) {
    side.weight(Eigen::Index(i)) = p.weight[i];
    side.still(Eigen::Index(i)) =
        kTipCounts + (1 - kTipCounts) * (1 - p.toNodes[i][graph.deepest] / farthest);
    for (size_t j = 0; j < n; ++j) side.distance(Eigen::Index(i), Eigen::Index(j)) = p.distance[i][j];
  }
  return side;
}

/// Scales exp(-cost / blur) to both sides' weights [Cut13].
Table scaled(const Table& cost, double blur, const Side& a, const Side& b) {
  Table exponent = -cost / blur;
  exponent.colwise() -= exponent.rowwise().maxCoeff().eval();
  Table plan = exponent.max(-600.0).exp();
  Column u = Column::Ones(cost.rows()), v = Column::Ones(cost.cols());
  for (int k = 0; k < kScalings; ++k) {
    u = a.weight / (plan.matrix() * v.matrix()).array().max(1e-300);
    v = b.weight / (plan.matrix().transpose() * u.matrix()).array().max(1e-300);
  }
  plan.colwise() *= u;
  plan.rowwise() *= v.transpose();
  return plan;
}

/// The search for a coupling of two sides.
class Coupling {
 public:
  Coupling(const Side& a, const Side& b) : a_(a), b_(b) {
    const Eigen::Index n = a.distance.rows(), m = b.distance.rows();
    unlike_.resize(n, m), still_.resize(n, m);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < m; ++j) {
        unlike_(i, j) = InnerPoints::unlike(a.points.fullness[size_t(i)], b.points.fullness[size_t(j)]);
        still_(i, j) = std::sqrt(a.still(i) * b.still(j));
      }
    still_ /= (a.weight.matrix().transpose() * still_.matrix() * b.weight.matrix())(0);
    const Column ofA = (a.distance.square().matrix() * a.weight.matrix()).array(),
                 ofB = (b.distance.square().matrix() * b.weight.matrix()).array();
    own_ = ofA.replicate(1, m) + ofB.transpose().replicate(n, 1);
  }

  Table byPosition() const {
    return scaled(squaredDistances(Mat3d::identity(), Vec3d(0.0), Vec3d(0.0)) + kUnlikePrice * unlike_,
                  kStartBlur, a_, b_);
  }

  Table refined(Table plan, const Course& course) const {
    for (int step = 0; step < course.steps; ++step) {
      const double along = double(step) / double(course.steps - 1);
      const double blur = course.from * std::pow(course.to / course.from, along);
      const Table inner = own_ - 2 * (a_.distance.matrix() * plan.matrix() * b_.distance.matrix()).array();
      plan = scaled(2 * inner + kPositionPrice * still_ * fittedDistances(plan) + kUnlikePrice * unlike_,
                    blur, a_, b_);
    }
    return plan;
  }

  /// Mean of (d_a(i, k) - d_b(j, l))^2 over what is coupled. With the plan's own sums, as few scalings do not quite reach
  /// the sides' weights.
  double distortion(const Table& plan) const {
    const Column ofA = plan.rowwise().sum() / plan.sum(), ofB = plan.colwise().sum().transpose() / plan.sum();
    const double own = (ofA * (a_.distance.square().matrix() * ofA.matrix()).array()).sum() +
                       (ofB * (b_.distance.square().matrix() * ofB.matrix()).array()).sum();
    const Table both = (a_.distance.matrix() * plan.matrix() * b_.distance.matrix()).array();
    return own - 2 * (plan * both).sum() / (plan.sum() * plan.sum());
  }

 private:
  Table squaredDistances(const Mat3d& turn, const Vec3d& from, const Vec3d& to) const {
    Table squared(a_.distance.rows(), b_.distance.rows());
    for (Eigen::Index i = 0; i < squared.rows(); ++i) {
      const Vec3d p = turn * (a_.at[size_t(i)] - from) + to;
      for (Eigen::Index j = 0; j < squared.cols(); ++j) squared(i, j) = (p - b_.at[size_t(j)]).lengthSqr();
    }
    return squared;
  }

  /// Distances after the rigid motion that fits a coupling best.
  Table fittedDistances(const Table& plan) const {
    const Table weight = plan * still_;
    Vec3d from(0.0), to(0.0);
    double sum = 0;
    for (Eigen::Index i = 0; i < plan.rows(); ++i)
      for (Eigen::Index j = 0; j < plan.cols(); ++j) {
        from += weight(i, j) * a_.at[size_t(i)], to += weight(i, j) * b_.at[size_t(j)];
        sum += weight(i, j);
      }
    from /= sum, to /= sum;
    Mat3d outer = Mat3d::zero();
    for (Eigen::Index i = 0; i < plan.rows(); ++i) {
      Vec3d pulled(0.0);
      for (Eigen::Index j = 0; j < plan.cols(); ++j) pulled += weight(i, j) * (b_.at[size_t(j)] - to);
      const Vec3d x = a_.at[size_t(i)] - from;
      addOuter(outer, 1, pulled, x);
    }
    return squaredDistances(nearestRotation(outer), from, to);
  }

  const Side &a_, &b_;
  Table unlike_, still_, own_;
};

/// Per point of the many the nearest of the first few.
std::vector<Eigen::Index> ownersOf(const InnerPoints& many, size_t few) {
  std::vector<Eigen::Index> owner;
  for (size_t i = 0; i < many.node.size(); ++i) {
    size_t best = 0;
    for (size_t k = 1; k < few; ++k)
      if (many.distance[k][i] < many.distance[best][i]) best = k;
    owner.push_back(Eigen::Index(best));
  }
  return owner;
}

/// A coupling of few points spread over the many: each has the part of its nearest one by weight.
Table spread(const Table& few, const Side& a, const Side& b) {
  const std::vector<Eigen::Index> ofA = ownersOf(a.points, size_t(few.rows())),
                                  ofB = ownersOf(b.points, size_t(few.cols()));
  Column sumA = Column::Zero(few.rows()), sumB = Column::Zero(few.cols());
  for (size_t i = 0; i < ofA.size(); ++i) sumA(ofA[i]) += a.points.weight[i];
  for (size_t j = 0; j < ofB.size(); ++j) sumB(ofB[j]) += b.points.weight[j];
  Table many(Eigen::Index(ofA.size()), Eigen::Index(ofB.size()));
  for (size_t i = 0; i < ofA.size(); ++i)
    for (size_t j = 0; j < ofB.size(); ++j)
      many(Eigen::Index(i), Eigen::Index(j)) =
          few(ofA[i], ofB[j]) * a.points.weight[i] * b.points.weight[j] / (sumA(ofA[i]) * sumB(ofB[j]));
  return many;
}

/// Per point of a side the mean place of what it is coupled to.
std::vector<Vec3d> imagesOf(const Side& side, const Side& other, const Table& plan) {
  std::vector<Vec3d> image(side.at.size(), Vec3d(0.0));
  for (size_t i = 0; i < image.size(); ++i) {
    double sum = 0;
    for (size_t j = 0; j < other.at.size(); ++j) {
      const double w = plan(Eigen::Index(i), Eigen::Index(j));
      image[i] += w * (other.mean + other.radius * other.at[j]), sum += w;
    }
    image[i] /= sum;
  }
  return image;
}

/// Where the nodes of one body go: each moves rigidly as the points around it do. `image`: of the side's points.
BodyPose poseOf(const BodyGraph& graph, const Side& side, const std::vector<Vec3d>& image) {
  const size_t n = side.at.size(), nodes = graph.position.size();
  std::vector<Vec3d> own;
  for (size_t node : side.points.node) own.push_back(graph.position[node]);
  // The rigid motions that fit, but for their rotations: sums of outer products.
  std::vector<Vec3d> from(nodes, Vec3d(0.0)), to(nodes, Vec3d(0.0));
  std::vector<Mat3d> outer(nodes, Mat3d::zero());
  tbb::parallel_for(size_t(0), nodes, [&](size_t node) {
    std::vector<double> weight(n);
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
      const double d = side.points.toNodes[i][node] / (side.points.unit * kCarryReach);
      weight[i] = (std::isfinite(d) ? side.points.weight[i] * std::exp(-0.5 * d * d) : 0) + 1e-30;
      from[node] += weight[i] * own[i], to[node] += weight[i] * image[i], sum += weight[i];
    }
    from[node] /= sum, to[node] /= sum;
    Mat3d spread = Mat3d::zero();
    for (size_t i = 0; i < n; ++i) {
      const Vec3d before = own[i] - from[node], after = image[i] - to[node];
      addOuter(outer[node], weight[i] / sum, after, before);
      addOuter(spread, weight[i] / sum, before, before);
    }
    // Directions in which the points hardly differ, as across a limb, tell nothing.
    outer[node] *= spread * (1 / std::max(spread(0, 0) + spread(1, 1) + spread(2, 2), 1e-30));
  });
  BodyPose pose{std::vector<Vec3d>(nodes), std::vector<Mat3d>(nodes, Mat3d::identity())};
  const std::vector<double> along = graph.distancesFrom(graph.deepest);
  std::vector<size_t> order(nodes);
  for (size_t i = 0; i < nodes; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](size_t i, size_t j) { return along[i] < along[j]; });
  for (size_t node : order) {
    // Of a node's neighbours those nearer to the middle have been turned already.
    Mat3d before = Mat3d::zero();
    int count = 0;
    for (int j : graph.neighbours[node])
      if (along[size_t(j)] < along[node]) before += pose.rotation[size_t(j)], ++count;
    double size = 0;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) size += outer[node](r, c) * outer[node](r, c);
    if (count > 0) outer[node] += kNoTwist * std::sqrt(size) / count * before;
    pose.rotation[node] = nearestRotation(outer[node]);
    pose.position[node] = to[node] + pose.rotation[node] * (graph.position[node] - from[node]);
  }
  return pose;
}

}  // namespace

BodyCoupling coupleBodies(const BodyGraph& a, const BodyGraph& b) {
  BodyCoupling result;
  const BodyGraph* graphs[2] = {&a, &b};
  Side few[2], many[2];
  tbb::parallel_for(0, 2, [&](int k) {
    const BodyGraph& graph = *graphs[k];
    InnerPoints points =
        innerPoints({graph.share, graph.deepest, [&](size_t i) { return graph.distancesFrom(i); }}, kMany);
    few[k] = sideOf(graph, fewerOf(points, kFew, graph.share));
    many[k] = sideOf(graph, std::move(points));
  });
  if (few[0].at.empty() || few[1].at.empty()) return result;
  const Coupling finding(few[0], few[1]), refining(many[0], many[1]);
  const Table found = finding.refined(finding.byPosition(), kFinding);
  const Table plan = refining.refined(spread(found, many[0], many[1]), kRefining);
  result.distortion = refining.distortion(plan);
  for (size_t k = 0; k < 2; ++k) {
    const std::vector<Vec3d> image = imagesOf(many[k], many[1 - k], k == 0 ? plan : Table(plan.transpose()));
    result.pose[k] = poseOf(*graphs[k], many[k], image);
    for (size_t i = 0; i < image.size(); ++i) {
      std::array<Vec3d, 2> pair;
      pair[k] = graphs[k]->position[many[k].points.node[i]], pair[1 - k] = image[i];
      result.partners.push_back(pair);
    }
  }
  return result;
}

}  // namespace slicemorph

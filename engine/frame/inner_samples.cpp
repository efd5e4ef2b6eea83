#include "engine/frame/inner_samples.h"

#include "engine/spine/geodesics.h"
#include "engine/spine/inner_points.h"

#include <Eigen/Core>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

// Figures of a prototype that found the right turn of 22 pairs (animals, hands, people).

/// Coarse nodes along the longest side and in all, at most.
constexpr int kInnerAlong = 48;
constexpr size_t kMostInner = 6000;
/// Blur of the soft matching, in squared radii, and its iterations.
constexpr double kBlur = 0.02;
constexpr int kMatchings = 40;
/// Prices of differing fullness in the matching and in the distortion, and of distance in the distortion.
constexpr double kFullnessPrice = 0.05, kDistancePrice = 0.1;

using Table = Eigen::ArrayXXd;

Table tableOf(const std::vector<std::vector<double>>& rows) {
  Table table(Eigen::Index(rows.size()), Eigen::Index(rows.size()));
  for (size_t i = 0; i < rows.size(); ++i)
    for (size_t j = 0; j < rows.size(); ++j) table(Eigen::Index(i), Eigen::Index(j)) = rows[i][j];
  return table;
}

/// Per node its share where it counts, in the largest connected part; 0 elsewhere.
std::vector<double> sharesOf(const InsideNodes& nodes, const Geodesics& paths) {
  const size_t count = nodes.position.size();
  std::vector<double> best(count, 0);
  std::vector<char> seen(count, 0);
  double most = 0;
  for (size_t start = 0; start < count; ++start) {
    if (seen[start]) continue;
    std::vector<size_t> part{start};
    seen[start] = 1;
    double volume = 0;
    for (size_t i = 0; i < part.size(); ++i) {
      volume += nodes.share[part[i]];
      for (const Geodesics::Neighbour& n : paths.neighbours(part[i]))
        if (!seen[n.node]) seen[n.node] = 1, part.push_back(n.node);
    }
    if (!(volume > most)) continue;
    most = volume;
    std::fill(best.begin(), best.end(), 0);
    for (size_t i : part) best[i] = nodes.bodyShare(i);
  }
  return best;
}

/// Points' weights are roots of volumes; whole volumes tell shapes' ways round apart by more, and vary less with where
/// the samples happen to lie.
void weighByVolume(InnerSamples& samples) {
  double sum = 0, squares = 0;
  for (double& w : samples.weight) w *= w, sum += w;
  for (double& w : samples.weight) w /= sum;
  for (size_t i = 0; i < samples.weight.size(); ++i)
    for (size_t j = 0; j < samples.weight.size(); ++j)
      squares += samples.weight[i] * samples.weight[j] * samples.distance[i][j] * samples.distance[i][j];
  for (auto& row : samples.distance)
    for (double& d : row) d /= std::sqrt(squares);
}

/// The distortion where each iteration scales a's weights first: the other order differs a little, because the
/// iterations are few.
double distortionFrom(const InnerSamples& a, const InnerSamples& b, const Mat3d& rotation) {
  const Eigen::Index n = Eigen::Index(a.position.size()), m = Eigen::Index(b.position.size());
  if (n == 0 || m == 0) return 0;
  Table squared(n, m), unlike(n, m);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec3d p = rotation * a.position[size_t(i)];
    for (Eigen::Index j = 0; j < m; ++j) {
      squared(i, j) = (p - b.position[size_t(j)]).lengthSqr();
      unlike(i, j) = InnerPoints::unlike(a.fullness[size_t(i)], b.fullness[size_t(j)]);
    }
  }
  const Eigen::ArrayXd p = Eigen::Map<const Eigen::ArrayXd>(a.weight.data(), n),
                       q = Eigen::Map<const Eigen::ArrayXd>(b.weight.data(), m);
  // Sinkhorn's iterations [Cut13]; rows' least costs are taken out before the exponential.
  Table cost = (squared + kFullnessPrice * unlike) / kBlur;
  cost.colwise() -= cost.rowwise().minCoeff().eval();
  const Table kernel = (-cost).max(-600.0).exp();
  Eigen::ArrayXd u = Eigen::ArrayXd::Ones(n), v = Eigen::ArrayXd::Ones(m);
  for (int k = 0; k < kMatchings; ++k) {
    u = p / (kernel.matrix() * v.matrix()).array().max(1e-300);
    v = q / (kernel.matrix().transpose() * u.matrix()).array().max(1e-300);
  }
  Table plan = kernel;
  plan.colwise() *= u;
  plan.rowwise() *= v.transpose();
  // The plan's own sums, as iterations that few do not reach the samples' weights: how far they are off depends on the
  // turn, and the distortion of what is not matched must not count for it.
  plan /= plan.sum();
  const Eigen::ArrayXd ofA = plan.rowwise().sum(), ofB = plan.colwise().sum().transpose();
  const Table ca = tableOf(a.distance), cb = tableOf(b.distance);
  const double own = (ofA.matrix().transpose() * ca.square().matrix() * ofA.matrix())(0) +
                     (ofB.matrix().transpose() * cb.square().matrix() * ofB.matrix())(0);
  const double both = (plan.matrix().array() * (ca.matrix() * plan.matrix() * cb.matrix()).array()).sum();
  return own - 2 * both + kDistancePrice * (plan * squared).sum() + kFullnessPrice * (plan * unlike).sum();
}

}  // namespace

InnerSamples innerSamples(const DistanceField& field, size_t count) {
  const InsideNodes nodes(field, kMostInner, kInnerAlong);
  InnerSamples samples;
  if (nodes.position.empty()) return samples;
  const Geodesics paths(nodes);
  InnerNodes inner{sharesOf(nodes, paths), 0, [&](size_t i) { return paths.from(i).length; }};
  for (size_t i = 0; i < inner.share.size(); ++i)
    if (inner.share[i] > 0 &&
        (inner.share[inner.deepest] == 0 || nodes.depth[i] > nodes.depth[inner.deepest]))
      inner.deepest = i;
  const InnerPoints points = innerPoints(inner, count);
  count = points.node.size();
  if (count == 0) return samples;
  samples.weight = points.weight, samples.distance = points.distance, samples.fullness = points.fullness;
  weighByVolume(samples);
  Vec3d mean(0.0);
  double radius = 0;
  for (size_t k = 0; k < count; ++k) mean += samples.weight[k] * nodes.position[points.node[k]];
  for (size_t k = 0; k < count; ++k) {
    samples.position.push_back(nodes.position[points.node[k]] - mean);
    radius += samples.weight[k] * samples.position[k].lengthSqr();
  }
  for (Vec3d& p : samples.position) p /= std::sqrt(radius);
  return samples;
}

double innerDistortion(const InnerSamples& a, const InnerSamples& b, const Mat3d& rotation) {
  // Not below 0, where rounding may lead.
  return std::max(0.5 * (distortionFrom(a, b, rotation) + distortionFrom(b, a, rotation.transpose())), 0.0);
}

}  // namespace slicemorph

#include "engine/frame/inner_samples.h"

#include "engine/spine/geodesics.h"

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
constexpr size_t kInnerSamples = 80;
/// Radii of the inner balls whose volumes are compared, and how softly they end, in root mean square distances.
constexpr double kBalls[2] = {0.3, 0.6}, kBallEdge = 0.1;
/// Added to volume shares before their logarithms.
constexpr double kEmptyBall = 1e-4;
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

/// Nodes spread over the inside, and the inner distances from each to all nodes, world units.
struct FarthestNodes {
  std::vector<size_t> node;
  std::vector<std::vector<double>> distance;
};

/// Each the farthest from those before; the first is the farthest from the deepest node.
FarthestNodes farthestNodes(const InsideNodes& nodes, const Geodesics& paths,
                            const std::vector<double>& share) {
  size_t deepest = 0;
  for (size_t i = 0; i < share.size(); ++i)
    if (share[i] > 0 && (share[deepest] == 0 || nodes.depth[i] > nodes.depth[deepest])) deepest = i;
  std::vector<double> nearest = paths.from(deepest).length;
  FarthestNodes chosen;
  while (chosen.node.size() < kInnerSamples) {
    size_t next = share.size();
    double most = 0;
    for (size_t i = 0; i < share.size(); ++i)
      if (share[i] > 0 && std::isfinite(nearest[i]) && nearest[i] > most) most = nearest[i], next = i;
    if (next == share.size()) break;
    chosen.node.push_back(next), chosen.distance.push_back(paths.from(next).length);
    for (size_t i = 0; i < nearest.size(); ++i)
      nearest[i] =
          chosen.node.size() == 1 ? chosen.distance[0][i] : std::min(nearest[i], chosen.distance.back()[i]);
  }
  return chosen;
}

/// Square roots of the volumes that are nearest to each node, of sum 1: between equal weights and volumes, as this
/// gave the largest margins.
std::vector<double> weightsOf(const FarthestNodes& chosen, const std::vector<double>& share) {
  std::vector<double> weight(chosen.node.size(), 0);
  for (size_t i = 0; i < share.size(); ++i) {
    size_t owner = 0;
    for (size_t k = 1; k < weight.size(); ++k)
      if (chosen.distance[k][i] < chosen.distance[owner][i]) owner = k;
    weight[owner] += share[i];
  }
  double sum = 0;
  for (double& w : weight) w = std::sqrt(w), sum += w;
  for (double& w : weight) w /= sum;
  return weight;
}

/// Logarithms of the shares of the volume within kBalls of each node. `unit`: world units per ball radius of 1.
std::vector<std::array<double, 2>> fullnessOf(const FarthestNodes& chosen, const std::vector<double>& share,
                                              double unit) {
  double volume = 0;
  for (double s : share) volume += s;
  std::vector<std::array<double, 2>> fullness(chosen.node.size());
  tbb::parallel_for(size_t(0), fullness.size(), [&](size_t k) {
    for (size_t ball = 0; ball < 2; ++ball) {
      double inside = 0;
      for (size_t i = 0; i < share.size(); ++i) {
        if (!(share[i] > 0)) continue;
        const double beyond = (chosen.distance[k][i] / unit - kBalls[ball]) / kBallEdge;
        inside += share[i] * std::min(std::max(0.5 - beyond, 0.0), 1.0);
      }
      fullness[k][ball] = std::log(kEmptyBall + inside / volume);
    }
  });
  return fullness;
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
      const double f = a.fullness[size_t(i)][0] - b.fullness[size_t(j)][0],
                   g = a.fullness[size_t(i)][1] - b.fullness[size_t(j)][1];
      unlike(i, j) = 0.5 * (f * f + g * g);
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
  const Table ca = tableOf(a.distance), cb = tableOf(b.distance);
  const double own = (p.matrix().transpose() * ca.square().matrix() * p.matrix())(0) +
                     (q.matrix().transpose() * cb.square().matrix() * q.matrix())(0);
  const double both = (plan.matrix().array() * (ca.matrix() * plan.matrix() * cb.matrix()).array()).sum();
  return own - 2 * both + kDistancePrice * (plan * squared).sum() + kFullnessPrice * (plan * unlike).sum();
}

}  // namespace

InnerSamples innerSamples(const DistanceField& field) {
  const InsideNodes nodes(field, kMostInner, kInnerAlong);
  InnerSamples samples;
  if (nodes.position.empty()) return samples;
  const Geodesics paths(nodes);
  const std::vector<double> share = sharesOf(nodes, paths);
  const FarthestNodes chosen = farthestNodes(nodes, paths, share);
  const size_t count = chosen.node.size();
  if (count == 0) return samples;
  samples.weight = weightsOf(chosen, share);
  double squares = 0;
  samples.distance.assign(count, std::vector<double>(count, 0));
  for (size_t i = 0; i < count; ++i)
    for (size_t j = 0; j < count; ++j) {
      const double d = 0.5 * (chosen.distance[i][chosen.node[j]] + chosen.distance[j][chosen.node[i]]);
      samples.distance[i][j] = d, squares += samples.weight[i] * samples.weight[j] * d * d;
    }
  const double unit = std::sqrt(squares);
  for (auto& row : samples.distance)
    for (double& d : row) d /= unit;
  samples.fullness = fullnessOf(chosen, share, unit);
  Vec3d mean(0.0);
  double radius = 0;
  for (size_t k = 0; k < count; ++k) mean += samples.weight[k] * nodes.position[chosen.node[k]];
  for (size_t k = 0; k < count; ++k) {
    samples.position.push_back(nodes.position[chosen.node[k]] - mean);
    radius += samples.weight[k] * samples.position[k].lengthSqr();
  }
  for (Vec3d& p : samples.position) p /= std::sqrt(radius);
  return samples;
}

double innerDistortion(const InnerSamples& a, const InnerSamples& b, const Mat3d& rotation) {
  return 0.5 * (distortionFrom(a, b, rotation) + distortionFrom(b, a, rotation.transpose()));
}

}  // namespace slicemorph

#include "engine/spine/inner_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace slicemorph {

namespace {

// Figures of a prototype that found the right turn of 22 pairs (animals, hands, people).

/// Radii of the inner balls whose volumes are compared, and how softly they end, in root mean square distances.
constexpr double kBalls[2] = {0.3, 0.6}, kBallEdge = 0.1;
/// Added to volume shares before their logarithms.
constexpr double kEmptyBall = 1e-4;

/// Square roots of the volumes that are nearest to each point, of sum 1: between equal weights and volumes, as this
/// gave the largest margins.
std::vector<double> weightsOf(const InnerPoints& points, const std::vector<double>& share) {
  std::vector<double> weight(points.node.size(), 0);
  for (size_t i = 0; i < share.size(); ++i) {
    size_t owner = 0;
    for (size_t k = 1; k < weight.size(); ++k)
      if (points.toNodes[k][i] < points.toNodes[owner][i]) owner = k;
    if (std::isfinite(points.toNodes[owner][i])) weight[owner] += share[i];
  }
  double sum = 0;
  for (double& w : weight) w = std::sqrt(w), sum += w;
  for (double& w : weight) w /= sum;
  return weight;
}

/// Logarithms of the shares of the volume within kBalls of each point.
std::vector<std::array<double, 2>> fullnessOf(const InnerPoints& points, const std::vector<double>& share) {
  double volume = 0;
  for (size_t i = 0; i < share.size(); ++i)
    if (std::isfinite(points.toNodes[0][i])) volume += share[i];
  std::vector<std::array<double, 2>> fullness(points.node.size());
  tbb::parallel_for(size_t(0), fullness.size(), [&](size_t k) {
    for (size_t ball = 0; ball < 2; ++ball) {
      double inside = 0;
      for (size_t i = 0; i < share.size(); ++i) {
        if (!(share[i] > 0)) continue;
        const double beyond = (points.toNodes[k][i] / points.unit - kBalls[ball]) / kBallEdge;
        inside += share[i] * std::min(std::max(0.5 - beyond, 0.0), 1.0);
      }
      fullness[k][ball] = std::log(kEmptyBall + inside / volume);
    }
  });
  return fullness;
}

/// Completes points of which the nodes and their distances to all nodes are known.
InnerPoints measured(InnerPoints points, const std::vector<double>& share) {
  points.weight = weightsOf(points, share);
  double squares = 0;
  const size_t found = points.node.size();
  points.distance.assign(found, std::vector<double>(found, 0));
  for (size_t i = 0; i < found; ++i)
    for (size_t j = 0; j < found; ++j) {
      const double d = 0.5 * (points.toNodes[i][points.node[j]] + points.toNodes[j][points.node[i]]);
      points.distance[i][j] = d, squares += points.weight[i] * points.weight[j] * d * d;
    }
  points.unit = std::sqrt(squares);
  for (auto& row : points.distance)
    for (double& d : row) d /= points.unit;
  points.fullness = fullnessOf(points, share);
  return points;
}

}  // namespace

InnerPoints innerPoints(const InnerNodes& nodes, size_t count) {
  InnerPoints points;
  const std::vector<double>& share = nodes.share;
  if (std::none_of(share.begin(), share.end(), [](double s) { return s > 0; })) return points;
  std::vector<double> nearest = nodes.distancesFrom(nodes.deepest);
  while (points.node.size() < count) {
    size_t next = share.size();
    double most = 0;
    for (size_t i = 0; i < share.size(); ++i)
      if (share[i] > 0 && std::isfinite(nearest[i]) && nearest[i] > most) most = nearest[i], next = i;
    if (next == share.size()) break;
    points.node.push_back(next), points.toNodes.push_back(nodes.distancesFrom(next));
    for (size_t i = 0; i < nearest.size(); ++i)
      nearest[i] =
          points.node.size() == 1 ? points.toNodes[0][i] : std::min(nearest[i], points.toNodes.back()[i]);
  }
  return points.node.empty() ? points : measured(std::move(points), share);
}

InnerPoints fewerOf(const InnerPoints& points, size_t count, const std::vector<double>& share) {
  InnerPoints fewer;
  count = std::min(count, points.node.size());
  if (count == 0) return fewer;
  fewer.node.assign(points.node.begin(), points.node.begin() + std::ptrdiff_t(count));
  fewer.toNodes.assign(points.toNodes.begin(), points.toNodes.begin() + std::ptrdiff_t(count));
  return measured(std::move(fewer), share);
}

}  // namespace slicemorph

#include "engine/spine/limbs.h"

#include "engine/spine/geodesics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace slicemorph {

namespace {

// Chosen by hand; tests/engine/spine/limbs_test.cpp counts the limbs of known shapes.

/// Least length of a branch beyond where it joins another, as a share of the longest path.
constexpr double kProminent = 0.12;
/// Least ratio of a branch's length to its width. A cartoon cow's forelegs are at 1.14.
constexpr double kLongerThanWide = 1.05;
/// Largest ratio of a branch's width to the body's greatest thickness (twice its depth): what is as thick as
/// the body is the body's own end.
constexpr double kThin = 0.9;

/// A branch less long than this, in its widths, may be a head with ears or horns.
constexpr double kStout = 3;
/// Twigs at a stout branch's end start where its radius falls below this share from one section to the next. From a
/// cow's head to its horns it falls to .43, in a rounded foot to .6.
constexpr double kTwig = 0.5;

/// A connected set of nodes beyond some distance from the body, grown from a tip inwards.
struct Branch {
  size_t tip;
  std::vector<size_t> nodes;
  bool ended = false;  ///< has met another branch already
};

/// The limb of a branch's nodes from the distance `root` outwards to `end`.
Limb limbOf(const InsideNodes& nodes, const std::vector<double>& distance, const Branch& branch, double root,
            double end) {
  constexpr int n = Limb::kSections;
  const double spacing = (end - root) / (n - 1);
  std::vector<Vec3d> sum(n, Vec3d(0.0));
  std::vector<double> weight(n, 0);
  for (size_t i : branch.nodes) {
    const double u = (distance[i] - root) / spacing;
    if (u < -0.5 || u > n - 0.5) continue;
    const int below = std::min(std::max(int(u), 0), n - 2);
    const double f = std::min(std::max(u - below, 0.0), 1.0);
    sum[below] += nodes.share[i] * (1 - f) * nodes.position[i], weight[below] += nodes.share[i] * (1 - f);
    sum[below + 1] += nodes.share[i] * f * nodes.position[i], weight[below + 1] += nodes.share[i] * f;
  }
  Limb limb;
  const double cell = nodes.spacing * nodes.spacing * nodes.spacing;
  for (int i = 0; i < n; ++i) {
    limb.line.push_back(weight[i] > 0 ? sum[i] / weight[i] : nodes.position[branch.tip]);
    limb.radius.push_back(std::sqrt(weight[i] * cell / (3.14159265 * spacing)));
  }
  if (end == distance[branch.tip]) limb.line.back() = nodes.position[branch.tip];
  limb.radius.back() = limb.radius[n - 2];
  for (int i = 1; i < n; ++i) limb.length += (limb.line[i] - limb.line[i - 1]).length();
  return limb;
}

double widthOf(const Limb& limb) {
  return 2 * std::accumulate(limb.radius.begin(), limb.radius.end(), 0.0) / double(limb.radius.size());
}

/// Which section of a limb is its last before twigs.
int lastSection(const Limb& limb) {
  const std::vector<double>& r = limb.radius;
  auto last = std::max_element(r.begin(), r.end());
  while (last + 1 != r.end() && *(last + 1) > kTwig * *last) ++last;
  return int(last - r.begin());
}

/// The limb of a branch; none if it is too short or too thick for one. A stout one ends where its twigs start: a muzzle
/// is no longer than the horns beside it, and a head that ended in a horn would have another's nose meet that.
std::optional<Limb> limbOfBranch(const InsideNodes& nodes, const std::vector<double>& distance,
                                 const Branch& branch, double root, double thickness) {
  const double end = distance[branch.tip];
  Limb limb = limbOf(nodes, distance, branch, root, end);
  const double width = widthOf(limb);
  if (!(limb.length > kLongerThanWide * width && width < kThin * thickness)) return {};
  const int last = lastSection(limb), whole = Limb::kSections - 1;
  if (limb.length < kStout * width && last < whole && last >= whole / 3)
    return limbOf(nodes, distance, branch, root, root + (end - root) * last / whole);
  return limb;
}

}  // namespace

std::vector<Limb> findLimbs(const DistanceField& field) {
  const InsideNodes nodes(field);
  if (nodes.position.empty()) return {};
  const Geodesics geodesics(nodes);
  const size_t body = size_t(std::max_element(nodes.depth.begin(), nodes.depth.end()) - nodes.depth.begin());
  const std::vector<double> distance = geodesics.from(body).length;
  std::vector<size_t> order;
  for (size_t i = 0; i < distance.size(); ++i)
    if (std::isfinite(distance[i])) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return distance[a] != distance[b] ? distance[a] > distance[b] : a < b;
  });
  if (order.empty()) return {};
  const double longest = distance[order[0]];

  // Visit nodes from the tips inwards: connected nodes are one branch until it meets another.
  std::vector<Branch> branches;
  std::vector<int> branchOf(distance.size(), -1);
  std::vector<Limb> limbs;
  const auto end = [&](Branch& branch, double root) {
    if (branch.ended) return;
    branch.ended = true;
    if (const auto limb = limbOfBranch(nodes, distance, branch, root, 2 * nodes.depth[body]))
      limbs.push_back(*limb);
  };
  for (size_t i : order) {
    int mine = -1;
    for (const Geodesics::Neighbour& n : geodesics.neighbours(i)) {
      int other = branchOf[n.node];
      if (other < 0 || other == mine) continue;
      if (mine < 0) {
        mine = other;
        continue;
      }
      // Two branches meet. If the shorter one is long enough, both end here; in any case its
      // nodes join the other's.
      Branch* a = &branches[size_t(mine)];
      Branch* b = &branches[size_t(other)];
      if (distance[a->tip] < distance[b->tip]) std::swap(a, b), std::swap(mine, other);
      if (distance[b->tip] - distance[i] > kProminent * longest) end(*a, distance[i]), end(*b, distance[i]);
      for (size_t node : b->nodes) branchOf[node] = mine, a->nodes.push_back(node);
      b->nodes.clear();
    }
    if (mine < 0) {
      mine = int(branches.size());
      branches.push_back({i, {}, false});
    }
    branchOf[i] = mine;
    branches[size_t(mine)].nodes.push_back(i);
  }
  return limbs;
}

}  // namespace slicemorph

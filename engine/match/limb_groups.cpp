#include "engine/match/limb_groups.h"

#include "engine/match/assignment.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace slicemorph {

namespace {

// The figures here and below are chosen by hand; tests/engine/match/limb_groups_test.cpp and
// tests/engine/spine/limbs_test.cpp guard what they are for.

/// Costs of matching two limbs, per distance of their roots and of their tips in units of the objects' size,
/// and per factor e of their lengths; and the cost of having no partner.
constexpr double kRootPrice = 2, kTipPrice = 0.5, kLengthPrice = 0.4, kAlonePrice = 1.7;
/// Points at the start of a limb's line whose mean is its root, where it leaves the body.
constexpr int kRootPoints = 4;

double costOf(const PlacedLimb& a, const PlacedLimb& b, double size) {
  Vec3d root(0.0);
  for (int i = 0; i < kRootPoints; ++i)
    root += (a.middle[size_t(i)] - b.middle[size_t(i)]) / double(kRootPoints);
  const double tip = (a.middle.back() - b.middle.back()).length();
  return (kRootPrice * root.length() + kTipPrice * tip) / size +
         kLengthPrice * std::abs(std::log(a.length / b.length));
}

/// The rotation of least angle that takes one direction to another.
Mat3d turnBetween(const Vec3d& from, const Vec3d& to) {
  Vec3d axis = from.cross(to);
  const double s = axis.length(), angle = std::atan2(s, from.dot(to));
  if (s < 1e-9) axis = from.cross(std::abs(from[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0));
  return rotationFromVector(axis.unit() * angle);
}

/// A limb as a root and, per segment, a length and a rotation-minimising coordinate frame [WJZL08] (first
/// column along the limb).
struct Stem {
  Vec3d root;
  std::vector<double> length;
  std::vector<Mat3d> frame;
};

Stem stemOf(const std::vector<Vec3d>& line, const Mat3d& firstFrame) {
  Stem stem{line[0], {}, {}};
  Mat3d frame = firstFrame;
  for (size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec3d d = line[i + 1] - line[i];
    stem.length.push_back(d.length());
    if (d.length() > 0) frame = turnBetween(frame.col(0), d.unit()) * frame;
    stem.frame.push_back(frame);
  }
  return stem;
}

/// Mean rotation, by fixed-point iteration in the tangent space.
Mat3d meanFrame(const std::vector<Mat3d>& frames) {
  Mat3d mean = frames[0];
  for (int i = 0; i < 20; ++i) {
    Vec3d step(0.0);
    for (const Mat3d& f : frames) step += rotationVector(mean.transpose() * f) / double(frames.size());
    mean = mean * rotationFromVector(step);
  }
  return mean;
}

/// Means of the roots, of the lengths, of the first frames and of the turns from segment to segment.
Stem meanStem(const std::vector<Stem>& stems) {
  const double share = 1.0 / double(stems.size());
  Stem mean = stems[0];
  mean.root = Vec3d(0.0);
  std::vector<Mat3d> first;
  for (const Stem& s : stems) mean.root += share * s.root, first.push_back(s.frame[0]);
  mean.frame[0] = meanFrame(first);
  for (size_t i = 0; i < mean.length.size(); ++i) {
    mean.length[i] = 0;
    for (const Stem& s : stems) mean.length[i] += share * s.length[i];
    if (i == 0) continue;
    Vec3d turn(0.0);
    for (const Stem& s : stems) turn += share * rotationVector(s.frame[i - 1].transpose() * s.frame[i]);
    mean.frame[i] = mean.frame[i - 1] * rotationFromVector(turn);
  }
  return mean;
}

/// The points of the centre line, each followed by four points around it at the limb's radius.
std::vector<Vec3d> pointsOf(const Stem& stem, const std::vector<double>& radius) {
  std::vector<Vec3d> points;
  Vec3d p = stem.root;
  for (size_t i = 0; i < radius.size(); ++i) {
    const Mat3d& frame = stem.frame[std::min(i, stem.frame.size() - 1)];
    const Vec3d x = radius[i] * frame.col(1), y = radius[i] * frame.col(2);
    const std::array<Vec3d, kPointsAround> around{x, -x, y, -y};
    points.push_back(p);
    for (const Vec3d& offset : around) points.push_back(p + offset);
    if (i < stem.length.size()) p += stem.length[i] * frame.col(0);
  }
  return points;
}

/// Largest depth of a stub, and largest distance from where the limb would start to the object's surface; in
/// lengths of the limb.
constexpr double kStubLength = 0.35, kStubReach = 0.5;

/// Per limb of `a` the index of its partner in `b`; -1: none. `size`: see groupLimbs.
std::vector<int> matchLimbs(const std::vector<PlacedLimb>& a, const std::vector<PlacedLimb>& b, double size) {
  if (a.empty() || b.empty()) return std::vector<int>(a.size(), -1);
  std::vector<std::vector<double>> cost(a.size(), std::vector<double>(b.size() + a.size(), kAlonePrice));
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t j = 0; j < b.size(); ++j) cost[i][j] = costOf(a[i], b[j], size);
  std::vector<int> partner = assign(cost);
  for (int& p : partner)
    if (p >= int(b.size())) p = -1;
  return partner;
}

/// The mean line and length, in the middle space, of the limbs of a group.
PlacedLimb meanOf(const std::vector<std::vector<PlacedLimb>>& limbs, const std::vector<int>& group) {
  PlacedLimb mean;
  double count = 0;
  for (size_t k = 0; k < limbs.size(); ++k) {
    if (group[k] < 0) continue;
    const PlacedLimb& limb = limbs[k][size_t(group[k])];
    if (mean.middle.empty()) mean.middle.assign(limb.middle.size(), Vec3d(0.0));
    for (size_t i = 0; i < mean.middle.size(); ++i) mean.middle[i] += limb.middle[i];
    mean.length += limb.length;
    ++count;
  }
  for (Vec3d& p : mean.middle) p /= count;
  mean.length /= count;
  return mean;
}

/// Groups of corresponding limbs: per group and object the index of its limb; -1: it has none. The objects
/// are added one by one, each matched with the means of the groups found so far.
std::vector<std::vector<int>> partnersOf(const std::vector<std::vector<PlacedLimb>>& limbs, double size) {
  std::vector<std::vector<int>> groups;
  for (size_t k = 0; k < limbs.size(); ++k) {
    std::vector<PlacedLimb> means;
    means.reserve(groups.size());
    for (const std::vector<int>& group : groups) means.push_back(meanOf(limbs, group));
    const std::vector<int> partner = matchLimbs(means, limbs[k], size);
    for (size_t i = 0; i < partner.size(); ++i) groups[i][k] = partner[i];
    for (size_t j = 0; j < limbs[k].size(); ++j) {
      if (std::find(partner.begin(), partner.end(), int(j)) != partner.end()) continue;
      groups.emplace_back(limbs.size(), -1);
      groups.back()[k] = int(j);
    }
  }
  return groups;
}

/// The stub of a limb that object k lacks: short, wholly below the surface, where the limb would be attached.
std::optional<PlacedLimb> stubOf(const PlacedLimb& limb, size_t k, const DistanceField& field,
                                 const Chart& chart, const Displacements& map) {
  const Vec3d root = limb.middle[0] + map.at(k, limb.middle[0]);
  const Vec3d world = field.closest(chart.toWorld(root));
  const Vec3d surface = chart.toChart(world);
  if ((surface - root).length() > kStubReach * limb.length) return {};
  const Vec3d out = chart.normalToChart(surface, field.gradient(world));
  // Go down as long as the distance to the surface grows.
  const double unit = 1 / chart.meanScale(), step = 0.02 * limb.length;
  double depth = 0, deepest = 0;
  while (depth < kStubLength * limb.length) {
    const double below = -unit * field.coarse(chart.toWorld(surface - (depth + step) * out));
    if (below < deepest) break;
    deepest = below, depth += step;
  }
  if (depth < 4 * step) return {};
  const double share = 0.7 * depth / limb.length;
  PlacedLimb stub = limb;
  const int n = int(limb.chart.size());
  for (int i = 0; i < n; ++i) {
    stub.chart[size_t(i)] = surface - depth * (0.85 - 0.7 * i / (n - 1.0)) * out;
    stub.radius[size_t(i)] *= std::sqrt(share);
  }
  return stub;
}

}  // namespace

std::vector<std::vector<PlacedLimb>> placedLimbs(const Fields& fields, const std::vector<Chart>& charts,
                                                 const Displacements& map) {
  std::vector<std::vector<PlacedLimb>> placed(fields.size());
  tbb::parallel_for(size_t(0), fields.size(), [&](size_t k) {
    for (const Limb& limb : findLimbs(*fields[k])) {
      PlacedLimb p;
      for (size_t i = 0; i < limb.line.size(); ++i) {
        p.chart.push_back(charts[k].toChart(limb.line[i]));
        Vec3d middle = p.chart.back() - map.at(k, p.chart.back());
        toMiddle(map, k, p.chart.back(), middle);
        p.middle.push_back(middle);
        p.radius.push_back(limb.radius[i] / charts[k].meanScale());
        if (i > 0) p.length += (p.middle[i] - p.middle[i - 1]).length();
      }
      placed[k].push_back(std::move(p));
    }
  });
  return placed;
}

std::vector<LimbGroup> groupLimbs(const std::vector<std::vector<PlacedLimb>>& limbs, const Fields& fields,
                                  const std::vector<Chart>& charts, const Displacements& map, double size) {
  std::vector<LimbGroup> groups;
  for (const std::vector<int>& partners : partnersOf(limbs, size)) {
    size_t has = 0;
    while (partners[has] < 0) ++has;
    LimbGroup group;
    for (size_t k = 0; k < limbs.size(); ++k) {
      if (partners[k] >= 0) {
        group.limb.push_back(limbs[k][size_t(partners[k])]);
        continue;
      }
      group.grows = true;
      const std::optional<PlacedLimb> stub =
          stubOf(limbs[has][size_t(partners[has])], k, *fields[k], charts[k], map);
      if (!stub) break;
      group.limb.push_back(*stub);
    }
    if (group.limb.size() == limbs.size()) groups.push_back(std::move(group));
  }
  return groups;
}

std::vector<Correspondence> limbPoints(const std::vector<PlacedLimb>& limbs) {
  std::vector<Stem> stems;
  for (const PlacedLimb& limb : limbs) {
    const Vec3d d = limb.chart[1] - limb.chart[0];
    const Vec3d along = d.length() > 0 ? d.unit() : Vec3d(1, 0, 0);
    // Each object's first frame is the first object's, turned as little as possible.
    Mat3d frame = stems.empty() ? turnBetween({1, 0, 0}, along) : stems[0].frame[0];
    frame = turnBetween(frame.col(0), along) * frame;
    stems.push_back(stemOf(limb.chart, frame));
  }
  std::vector<double> meanRadius(limbs[0].radius.size(), 0);
  for (const PlacedLimb& limb : limbs)
    for (size_t i = 0; i < meanRadius.size(); ++i) meanRadius[i] += limb.radius[i] / double(limbs.size());
  const std::vector<Vec3d> middle = pointsOf(meanStem(stems), meanRadius);
  std::vector<Correspondence> points(middle.size());
  for (size_t i = 0; i < middle.size(); ++i) points[i].middle = middle[i];
  for (size_t k = 0; k < limbs.size(); ++k) {
    const std::vector<Vec3d> own = pointsOf(stems[k], limbs[k].radius);
    for (size_t i = 0; i < own.size(); ++i) points[i].at.push_back(own[i]);
  }
  return points;
}

}  // namespace slicemorph

#include "engine/match/features.h"

#include "engine/spine/chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace slicemorph {

namespace {

// The figures below are chosen by hand; tests/engine/match/features_test.cpp and
// tests/engine/features_test.cpp guard what they are for.

/// Weight in the fit, against 1 of a surface sample. A mark counts as much as a patch of the surface, so that
/// samples near it cannot outvote it; each of the many points along a line counts less.
constexpr float kMarkWeight = 100, kLineWeight = 10;
/// Segments of a resampled line, and points on a disk's rim.
constexpr int kLinePieces = 12, kRim = 8;
/// Fraction of an object's diagonal: a feature further than this from every surface is left out.
constexpr double kFar = 0.1;
/// Fraction of the objects' size in chart space: lines whose ends are nearer to each other are joined.
constexpr double kJoined = 0.01;
/// Least radius of a line, fraction of the same size: on the surface its depth is 0.
constexpr double kThinnest = 0.008;
/// Fraction of the size: a feature whose points miss by more is not met.
constexpr double kUnmet = 0.02;

using Line = std::vector<Vec3d>;

/// Corresponding lines (or points) of all objects, chart coordinates, with equally many points.
using LineGroup = std::vector<Line>;

/// The polyline resampled to `pieces` + 1 points at equal steps of its length.
Line evenly(const Line& line, int pieces) {
  std::vector<double> length{0};
  for (size_t i = 1; i < line.size(); ++i) length.push_back(length.back() + (line[i] - line[i - 1]).length());
  Line result;
  size_t i = 1;
  for (int n = 0; n <= pieces; ++n) {
    const double at = length.back() * n / pieces;
    while (i + 1 < line.size() && length[i] < at) ++i;
    const double step = length[i] - length[i - 1], f = step > 0 ? (at - length[i - 1]) / step : 0;
    result.push_back(line[i - 1] + std::min(std::max(f, 0.0), 1.0) * (line[i] - line[i - 1]));
  }
  return result;
}

/// Mean diagonal of the objects' boxes, chart units.
double sizeOf(const Fields& fields, const std::vector<Chart>& charts) {
  double size = 0;
  for (size_t k = 0; k < fields.size(); ++k)
    size += fields[k]->box().extents().length() / charts[k].meanScale() / double(fields.size());
  return size;
}

/// The largest distance of a line's start (or end) on any object from that on the first.
double movement(const LineGroup& group, bool atEnd) {
  double most = 0;
  for (const Line& line : group)
    most = std::max(
        most, atEnd ? (line.back() - group[0].back()).length() : (line.front() - group[0].front()).length());
  return most;
}

void reverse(LineGroup& group) {
  for (Line& line : group) std::reverse(line.begin(), line.end());
}

bool follows(const LineGroup& first, const LineGroup& second, double near) {
  for (size_t k = 0; k < first.size(); ++k)
    if ((first[k].back() - second[k].front()).length() > near) return false;
  return true;
}

/// Joins groups of which one ends where the other begins, on all objects.
void joinLines(std::vector<LineGroup>& groups, double near) {
  for (size_t i = 0; i < groups.size(); ++i)
    for (size_t j = 0; j < groups.size(); ++j) {
      if (i == j || !follows(groups[i], groups[j], near)) continue;
      for (size_t k = 0; k < groups[i].size(); ++k)
        groups[i][k].insert(groups[i][k].end(), groups[j][k].begin() + 1, groups[j][k].end());
      groups.erase(groups.begin() + std::ptrdiff_t(j));
      i = size_t(-1);  // start again: the longer line may join one compared before
      break;
    }
}

/// Unit direction in chart space of a world direction, by a step of `length` world units.
Vec3d chartDirection(const Chart& chart, const Vec3d& at, const Vec3d& direction, double length) {
  return (chart.toChart(at + length * direction) - chart.toChart(at)).unit();
}

/// The disk's centre, a point on either side of it and points on its rim, in chart coordinates. Each rim
/// starts where the least rotation between the normals takes the first object's start.
LineGroup diskPoints(const Feature& disk, const std::vector<Chart>& charts) {
  LineGroup points(charts.size());
  Vec3d first(0.0), side(0.0);
  for (size_t k = 0; k < charts.size(); ++k) {
    const Vec3d& center = disk.positions[k][0];
    const double radius = disk.radii[k];
    const Vec3d normal = disk.normals[k].unit();
    const Vec3d n = chartDirection(charts[k], center, normal, 0.1 * radius);
    if (k == 0) {
      first = n;
      side = n.cross(std::abs(n[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).unit();
    }
    const Vec3d axis = first.cross(n);
    const double sine = axis.length();
    const Vec3d own =
        sine > 1e-9 ? rotationFromVector(axis / sine * std::atan2(sine, first.dot(n))) * side : side;
    const Vec3d z = charts[k].toChart(center);
    Vec3d e1 = charts[k].toWorld(z + 0.1 * radius / charts[k].meanScale() * own) - center;
    e1 = (e1 - e1.dot(normal) * normal).unit();
    const Vec3d e2 = normal.cross(e1);
    points[k].push_back(z);
    for (double side : {-0.5, 0.5}) points[k].push_back(charts[k].toChart(center + side * radius * normal));
    for (int i = 0; i < kRim; ++i) {
      const double angle = 2 * M_PI * i / kRim;
      points[k].push_back(charts[k].toChart(center + radius * (std::cos(angle) * e1 + std::sin(angle) * e2)));
    }
  }
  return points;
}

/// The points of a group as correspondences; the middle points are the means.
void addMarks(const LineGroup& points, float weight, std::vector<Correspondence>& marks) {
  for (size_t i = 0; i < points[0].size(); ++i) {
    Correspondence c;
    for (const Line& own : points) {
      c.at.push_back(own[i]);
      c.middle += own[i] / double(points.size());
    }
    c.weight = weight;
    marks.push_back(std::move(c));
  }
}

/// A line as a limb of every object; its radius is the depth below the surface.
std::vector<PlacedLimb> limbsOf(const LineGroup& group, const Fields& fields,
                                const std::vector<Chart>& charts, double size) {
  std::vector<PlacedLimb> limbs;
  for (size_t k = 0; k < group.size(); ++k) {
    PlacedLimb limb;
    limb.chart = limb.middle = group[k];
    for (const Vec3d& z : group[k]) {
      const double depth = -double(fields[k]->coarse(charts[k].toWorld(z))) / charts[k].meanScale();
      limb.radius.push_back(std::max(depth, kThinnest * size));
    }
    limbs.push_back(std::move(limb));
  }
  return limbs;
}

/// The points of a feature that a map should meet, per object, chart coordinates.
LineGroup featurePoints(const Feature& feature, const std::vector<Chart>& charts) {
  if (feature.kind == Feature::Kind::kDisk) return diskPoints(feature, charts);
  LineGroup points;
  for (size_t k = 0; k < charts.size(); ++k) {
    Line own;
    for (const Vec3d& p : feature.positions[k]) own.push_back(charts[k].toChart(p));
    points.push_back(own.size() > 1 ? evenly(own, kLinePieces) : own);
  }
  return points;
}

/// How far a feature's points, mapped to the middle space, lie from their mean over the objects, at most.
double missOf(const LineGroup& points, const Displacements& map, const std::vector<MiddleGuess>& guesses) {
  double most = 0;
  for (size_t i = 0; i < points[0].size(); ++i) {
    std::vector<Vec3d> middle;
    Vec3d mean(0.0);
    for (size_t k = 0; k < points.size(); ++k) {
      Vec3d s = guesses[k].near(points[k][i]);
      if (!toMiddle(map, k, points[k][i], s)) break;
      middle.push_back(s), mean += s / double(points.size());
    }
    if (middle.size() < points.size()) continue;
    for (const Vec3d& s : middle) most = std::max(most, (s - mean).length());
  }
  return most;
}

/// How much two features contradict each other: the largest change, from the first object to another, of the
/// vector between two of their points, relative to its length.
double conflict(const LineGroup& a, const LineGroup& b, double size) {
  double most = 0;
  for (size_t i = 0; i < a[0].size(); ++i)
    for (size_t j = 0; j < b[0].size(); ++j)
      for (size_t k = 1; k < a.size(); ++k) {
        const Vec3d here = a[0][i] - b[0][j], there = a[k][i] - b[k][j];
        most = std::max(most,
                        (here - there).length() / (std::min(here.length(), there.length()) + kUnmet * size));
      }
  return most;
}

}  // namespace

FeaturePoints placeFeatures(const std::vector<Feature>& features, const Fields& fields,
                            const std::vector<Chart>& charts) {
  FeaturePoints result;
  const double size = features.empty() ? 1 : sizeOf(fields, charts);
  std::vector<LineGroup> lines;
  for (const Feature& feature : features) {
    LineGroup points = featurePoints(feature, charts);
    if (feature.kind == Feature::Kind::kLine)
      lines.push_back(std::move(points));
    else
      addMarks(points, kMarkWeight, result.marks);
  }
  joinLines(lines, kJoined * size);
  result.limbs.resize(fields.size());
  for (LineGroup& line : lines) {
    // A line starts at the end that moves least, where a limb leaves the body.
    if (movement(line, true) < movement(line, false)) reverse(line);
    const std::vector<PlacedLimb> limbs = limbsOf(line, fields, charts, size);
    for (Correspondence& c : limbPoints(limbs)) {
      c.weight = kLineWeight;
      result.lines.push_back(std::move(c));
    }
    for (size_t k = 0; k < limbs.size(); ++k) result.limbs[k].push_back(limbs[k]);
  }
  return result;
}

Vec3d pointAlong(const std::vector<Vec3d>& line, double share) {
  if (line.size() == 1) return line[0];
  constexpr int kSteps = 1000;
  return evenly(line, kSteps)[size_t(std::lround(share * kSteps))];
}

bool isPrescribedBy(const PlacedLimb& limb, const std::vector<PlacedLimb>& lines) {
  const size_t outer = limb.chart.size() / 2;
  for (const PlacedLimb& line : lines)
    for (size_t i = outer; i < limb.chart.size(); ++i)
      for (size_t j = 0; j < line.chart.size(); ++j)
        if ((limb.chart[i] - line.chart[j]).length() < 1.5 * limb.radius[i]) return true;
  return false;
}

FeaturesInReach featuresInReach(const std::vector<Feature>& features, const Fields& fields) {
  FeaturesInReach result;
  for (const Feature& feature : features) {
    bool near = false;
    for (size_t k = 0; k < fields.size(); ++k)
      for (const Vec3d& p : feature.positions[k])
        near |= fields[k]->coarse(p) < kFar * fields[k]->box().extents().length();
    if (near)
      result.features.push_back(feature);
    else
      result.notes.push_back({"features.far", Severity::kWarning, "feature '" + feature.name + "'",
                              "lies far from every object's surface and is left out"});
  }
  return result;
}

Notes contradictions(const std::vector<Feature>& features, const std::vector<Chart>& charts,
                     const Displacements& map, double size) {
  Notes warnings;
  if (features.empty()) return warnings;
  std::vector<MiddleGuess> guesses;
  for (const VectorField& field : map.of) guesses.emplace_back(map.lattice, field);
  std::vector<LineGroup> points;
  std::vector<double> miss;
  for (const Feature& feature : features) {
    points.push_back(featurePoints(feature, charts));
    miss.push_back(missOf(points.back(), map, guesses));
  }
  std::set<std::pair<size_t, size_t>> prescribed;
  for (size_t i = 0; i < features.size(); ++i) {
    if (!(miss[i] > kUnmet * size)) continue;
    size_t against = i;
    double most = 0;
    for (size_t j = 0; j < features.size(); ++j)
      if (const double c = i == j ? 0 : conflict(points[i], points[j], size); c > most) most = c, against = j;
    char off[64];
    std::snprintf(off, sizeof off, "%.3g world units", miss[i] * charts[0].meanScale());
    if (against == i || most < 1) {
      warnings.push_back(
          {"features.contradict", Severity::kWarning, "",
           "feature '" + features[i].name + "' is missed by " + off + ": no map without folds meets it"});
    } else if (prescribed.insert(std::minmax(i, against)).second) {
      warnings.push_back({"features.contradict", Severity::kWarning, "",
                          "features '" + features[i].name + "' and '" + features[against].name +
                              "' contradict each other: no map without folds meets both; '" +
                              features[i].name + "' is missed by " + off});
    }
  }
  return warnings;
}

}  // namespace slicemorph

#include "engine/frame/align.h"

#include "engine/errors.h"
#include "engine/frame/moments.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {

namespace {

constexpr double kPi = 3.14159265358979323846;
/// Overlap that a turn of 90 degrees must win to be worth it.
constexpr double kPricePerRightAngle = 0.02;
/// What leaving the world's own directions must win at all: near-degenerate axes must not turn by noise.
constexpr double kTurnMargin = 0.01;
/// Scores closer than this are a tie (a symmetric object has several equally good turns).
constexpr double kTie = 0.004;

/// One object without its place and size: n -> centroid + size * n.
struct Normalised {
  const DistanceField* field;
  Moments moments;
  double size;
  float inside(const Vec3d& n) const {
    const double d = field->coarse(moments.centroid + size * n) / size;
    return float(std::min(std::max(0.5 - d / 0.1, 0.0), 1.0));
  }
};

Normalised normalise(const DistanceField& field) {
  const Moments m = insideMoments(field);
  return {&field, m, std::cbrt(m.volume)};
}

double reach(const Normalised& o) {
  double r = 0;
  for (int corner = 0; corner < 3; ++corner) {
    const Vec3d lo = o.field->box().min() - o.moments.centroid, hi = o.field->box().max() - o.moments.centroid;
    r = std::max({r, std::abs(lo[corner]), std::abs(hi[corner])});
  }
  return r / o.size;
}

Mat3d halfOf(const Mat3d& rotation) { return rotationFromVector(0.5 * rotationVector(rotation)); }

/// Soft intersection over union of a and b when `rotation` carries a onto b; sampled in the frame half way between.
double overlapOf(const Normalised& a, const Normalised& b, const Mat3d& rotation, int steps) {
  const Mat3d half = halfOf(rotation), back = half.transpose();
  const double r = std::min(std::max(reach(a), reach(b)), 4.0) * 1.05;
  double both = 0, either = 0;
  for (int k = 0; k < steps; ++k)
    for (int j = 0; j < steps; ++j)
      for (int i = 0; i < steps; ++i) {
        const Vec3d n = (Vec3d(i, j, k) * (2.0 / (steps - 1)) - Vec3d(1.0)) * r;
        const float fa = a.inside(back * n), fb = b.inside(half * n);
        both += std::min(fa, fb), either += std::max(fa, fb);
      }
  return either > 0 ? both / either : 0;
}

double angleOf(const Mat3d& rotation) { return rotationVector(rotation).length(); }

std::vector<Mat3d> properAxisAssignments() {
  std::vector<Mat3d> result;
  int p[3] = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Mat3d m = Mat3d::zero();
      for (int i = 0; i < 3; ++i) m(i, p[i]) = signs >> i & 1 ? -1 : 1;
      if (m.det() > 0) result.push_back(m);
    }
  } while (std::next_permutation(p, p + 3));
  return result;
}

Vec3d column(const Mat3d& m, int j) { return {m(0, j), m(1, j), m(2, j)}; }

/// The smallest rotation that takes one direction to another; none is singled out for opposite ones.
Mat3d smallestTurn(const Vec3d& from, const Vec3d& to) {
  const Vec3d axis = from.cross(to);
  const double s = axis.length(), c = from.dot(to);
  if (s < 1e-9) {
    if (c > 0) return Mat3d::identity();
    Vec3d side = std::abs(from[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    return rotationFromVector(from.cross(side).unit() * kPi);
  }
  return rotationFromVector(axis / s * std::atan2(s, c));
}

struct Candidate {
  Mat3d rotation = Mat3d::identity();
  double overlap = 0;
  bool world = false;  ///< started from the world's own directions
  double score() const {
    return overlap - kPricePerRightAngle * angleOf(rotation) / (kPi / 2) + (world ? kTurnMargin : 0);
  }
};

/// Coordinate ascent over small turns about three axes; kept only where it wins clearly.
Candidate refine(const Normalised& a, const Normalised& b, Candidate c, double step, int steps) {
  Candidate best = c;
  best.overlap = overlapOf(a, b, c.rotation, steps);
  const double start = best.score();
  const Candidate unrefined = best;
  for (; step > 0.008; step *= 0.5)
    for (bool moved = true; moved;) {
      moved = false;
      for (int axis = 0; axis < 6; ++axis) {
        Vec3d v(0.0);
        v[axis / 2] = axis % 2 ? -step : step;
        Candidate next = best;
        const Mat3d half = halfOf(best.rotation);
        next.rotation = half * rotationFromVector(v) * half;
        next.overlap = overlapOf(a, b, next.rotation, steps);
        if (next.score() > best.score() + 1e-4) best = next, moved = true;
      }
    }
  return best.score() > start + kTurnMargin ? best : unrefined;
}

/// The rotation that carries a's directions to b's.
Candidate bestTurn(const Normalised& a, const Normalised& b) {
  const PrincipalAxes pa = principalAxes(a.moments.covariance), pb = principalAxes(b.moments.covariance);
  std::vector<Candidate> candidates(1);
  candidates[0].world = true;
  for (const Mat3d& p : properAxisAssignments()) candidates.push_back({pb.axes * p * pa.axes.transpose()});
  for (double sign : {1.0, -1.0})
    candidates.push_back({smallestTurn(column(pa.axes, 0), sign * column(pb.axes, 0))});
  tbb::parallel_for(size_t(0), candidates.size(), [&](size_t i) {
    candidates[i].overlap = overlapOf(a, b, candidates[i].rotation, 28);
  });
  // The world's own directions are always looked at closely, with the best few of the others.
  std::stable_sort(candidates.begin() + 1, candidates.end(),
                   [](const Candidate& x, const Candidate& y) { return x.score() > y.score(); });
  candidates.resize(std::min<size_t>(candidates.size(), 9));
  tbb::parallel_for(size_t(0), candidates.size(), [&](size_t i) {
    const bool loose = i > 0 && candidates[i].overlap < 0.9;
    candidates[i] = refine(a, b, candidates[i], loose ? 0.3 : 0.08, 32);
  });
  const Vec3d spine = column(pa.axes, 0);
  const auto leaning = [&](const Candidate& c) {
    const Vec3d m = halfOf(c.rotation) * spine;
    return std::abs(m[0] + m[1] + m[2]);
  };
  const Candidate* best = &candidates[0];
  for (const Candidate& c : candidates)
    if (c.score() > best->score() + kTie || (c.score() > best->score() - kTie && leaning(c) > leaning(*best) + 1e-3))
      best = &c;
  return *best;
}

struct Extent {
  double low, high;
};

/// Extent of the surface along a direction, from the coarse closest points' source: the band's own points.
Extent extentAlong(const std::vector<SurfaceSample>& samples, const Vec3d& direction) {
  Extent e{1e300, -1e300};
  for (const SurfaceSample& s : samples) {
    const double d = s.position.dot(direction);
    e.low = std::min(e.low, d), e.high = std::max(e.high, d);
  }
  return e;
}

/// Shared axes, in the directions half way between the objects: of the pooled covariance, and the world's where that is nearly round.
Mat3d sharedAxes(const std::vector<Normalised>& objects, const std::vector<Mat3d>& rotations, const Vec3d& axis) {
  Mat3d pooled = Mat3d::zero();
  for (size_t k = 0; k < objects.size(); ++k)
    pooled += rotations[k].transpose() * objects[k].moments.covariance * rotations[k] *
              (1.0 / (objects[k].size * objects[k].size));
  PrincipalAxes p = principalAxes(pooled);
  constexpr double kRound = 1.15;
  Vec3d e0 = column(p.axes, 0);
  if (p.variances[0] < kRound * p.variances[1]) {
    // No single longest direction: take the world axis that lies most nearly along the widest plane.
    int widest = 0;
    for (int a = 1; a < 3; ++a)
      if (pooled(a, a) > pooled(widest, widest) * kRound) widest = a;
    e0 = Vec3d(0.0);
    e0[widest] = 1;
  }
  if (axis.length() > 0) e0 = axis.unit();
  int lead = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(e0[a]) > std::abs(e0[lead]) + 1e-9) lead = a;
  if (e0[lead] < 0) e0 = -e0;
  Vec3d e1 = column(p.axes, 1);
  const bool roundSection = p.variances[1] < kRound * p.variances[2] || std::abs(e1.dot(e0)) > 0.3;
  if (roundSection) {
    e1 = Vec3d(0.0);
    e1[(lead + 1) % 3] = 1;
  }
  e1 = (e1 - e1.dot(e0) * e0).unit();
  const Vec3d e2 = e0.cross(e1);
  return Mat3d(e0[0], e1[0], e2[0], e0[1], e1[1], e2[1], e0[2], e1[2], e2[2]);
}

std::string describe(const Mat3d& rotation) {
  char text[96];
  std::snprintf(text, sizeof text, "turned by %.1f degrees", angleOf(rotation) * 180 / kPi);
  return angleOf(rotation) < 1e-9 ? "kept in its own directions" : text;
}

/// All objects in one chart: world positions and directions are kept.
Frames worldFrames(const std::vector<Normalised>& objects, const Vec3d& axis) {
  const std::vector<Mat3d> none(objects.size(), Mat3d::identity());
  const Mat3d axes = sharedAxes(objects, none, axis);
  openvdb::BBoxd box;
  double size = 0;
  for (const Normalised& o : objects) box.expand(o.field->box()), size += o.size / double(objects.size());
  Chart chart;
  chart.center = box.getCenter();
  chart.axes = axes;
  chart.scale = Vec3d(size);
  Frames frames;
  frames.charts.assign(objects.size(), chart);
  frames.halfLength = 0.5 * box.extents().dot(Vec3d(std::abs(axes(0, 0)), std::abs(axes(1, 0)), std::abs(axes(2, 0)))) / size;
  frames.notes.push_back("positions and directions kept as they are in the world");
  return frames;
}

}  // namespace

Frames alignFrames(const Fields& fields, const MorphOptions& options) {
  std::vector<Normalised> objects(fields.size());
  tbb::parallel_for(size_t(0), fields.size(), [&](size_t k) { objects[k] = normalise(*fields[k]); });
  if (options.align == Align::kNone) return worldFrames(objects, options.axis);

  Frames frames;
  std::vector<Mat3d> rotations(fields.size(), Mat3d::identity());
  for (size_t k = 1; k < fields.size(); ++k) {
    const Candidate turn = bestTurn(objects[0], objects[k]);
    rotations[k] = turn.rotation;
    char text[64];
    std::snprintf(text, sizeof text, ", overlap %.2f before warping", turn.overlap);
    frames.notes.push_back("object " + std::to_string(k + 1) + " " + describe(turn.rotation) + text);
  }
  // From here on seen from half way between all objects, so that no object is special.
  std::vector<Chart> turned(fields.size());
  for (size_t k = 0; k < fields.size(); ++k) turned[k].axes = rotations[k];
  const Mat3d middle = blendCharts(turned, Weights(fields.size(), 1.0 / double(fields.size()))).axes;
  for (Mat3d& rotation : rotations) rotation = rotation * middle.transpose();
  const Mat3d shared = sharedAxes(objects, rotations, rotations[0].transpose() * options.axis);
  std::vector<double> lengths(fields.size()), radii(fields.size());
  double aspect = 0;
  frames.charts.resize(fields.size());
  for (size_t k = 0; k < fields.size(); ++k) {
    Chart& chart = frames.charts[k];
    chart.axes = rotations[k] * shared;
    const Vec3d spine = column(chart.axes, 0);
    const Extent e = extentAlong(sampleSurface(*fields[k], 20000), spine);
    lengths[k] = 0.5 * (e.high - e.low);
    radii[k] = std::sqrt(objects[k].moments.volume / (2 * lengths[k]));
    aspect += lengths[k] / radii[k] / double(fields.size());
    const Vec3d& c = objects[k].moments.centroid;
    chart.center = c + (0.5 * (e.high + e.low) - c.dot(spine)) * spine;
  }
  for (size_t k = 0; k < fields.size(); ++k)
    frames.charts[k].scale = Vec3d(lengths[k] / aspect, radii[k], radii[k]);
  frames.halfLength = aspect;
  return frames;
}

}  // namespace slicemorph

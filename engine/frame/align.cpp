#include "engine/frame/align.h"

#include "engine/frame/climb_rotation.h"
#include "engine/frame/feature_turns.h"
#include "engine/volume/moments.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {

namespace {

// Figures in overlap. Unless noted they are chosen by hand and guarded by tests/engine/morph_test.cpp and the
// tests `Facing` in tests/engine/pairs_test.cpp.

/// Overlap that a turn of 90 degrees must gain to become a candidate; from the method's prototype.
constexpr double kSmallPrice = 0.02;
/// Overlap that a turn of 90 degrees must gain, after warping, to be made; and gain that any turn needs, so
/// that noise does not turn shapes with nearly equal axes.
constexpr double kPricePerRightAngle = 0.12, kTurnMargin = 0.01;
/// The same for turns about the up direction, which leave upright models upright.
constexpr double kUprightPricePerRightAngle = 0.04;
/// A turn of at least this overlap, and of this gain over none, is taken without trying others.
constexpr double kDecisive = 0.8, kDecisiveGain = 0.1;
/// Above this overlap the shapes are taken to be equal up to a rotation.
constexpr double kSameShape = 0.95;
/// Scores closer than this are a tie (a symmetric object has several equally good turns).
constexpr double kTie = 0.004;
/// Turns to try besides none.
constexpr size_t kTurnsWorthTrying = 3;
/// From this overlap on, directions that no turn improves are right.
constexpr double kSureOverlap = 0.7;
/// Turns nearer to each other than this angle, radians, are one.
constexpr double kSameTurn = 0.35;

/// One object with position and size normalised: n -> centroid + size * n.
struct Normalised {
  const DistanceField* field;
  Moments moments;
  double size;                         ///< cube root of the volume, world units
  std::vector<openvdb::Vec3s> points;  ///< a regular grid's points inside, normalised
  double self = 1;                     ///< mean of inside() over its own points
  Lattice nodes;                ///< normalised: those nodes of the field's coarse grid that `inside` reads
  std::vector<float> distance;  ///< at the nodes, normalised

  /// 1 inside, 0 outside, with a ramp of a tenth of the size. `q`: a point in node units.
  float inside(const openvdb::Vec3s& q) const {
    for (int a = 0; a < 3; ++a)
      if (!(q[a] > 0 && q[a] < float(nodes.size[a] - 1))) return 0;
    const int x = int(q[0]), y = int(q[1]), z = int(q[2]);
    const float wx = q[0] - float(x), wy = q[1] - float(y), wz = q[2] - float(z);
    const float* v = &distance[nodes.index(x, y, z)];
    const size_t dy = size_t(nodes.size[0]), dz = dy * size_t(nodes.size[1]);
    const auto row = [&](size_t o) { return v[o] + wx * (v[o + 1] - v[o]); };
    const float n0 = row(0), f0 = row(dz);
    const float near = n0 + wy * (row(dy) - n0), far = f0 + wy * (row(dz + dy) - f0);
    return std::min(std::max(0.5f - (near + wz * (far - near)) / 0.1f, 0.f), 1.f);
  }
};

/// Mean of b.inside over a's points turned by `rotation`.
double shareInside(const Normalised& a, const Normalised& b, const Mat3d& rotation) {
  const openvdb::math::Mat3<float> toNodes(rotation * (1 / b.nodes.spacing));
  const openvdb::Vec3s first(b.nodes.origin * (-1 / b.nodes.spacing));
  double sum = 0;
  for (const openvdb::Vec3s& n : a.points) sum += b.inside(toNodes * n + first);
  return sum / double(a.points.size());
}

/// Takes as many nodes of the field as a ramp of `inside` needs: two to its length.
void takeNodes(const DistanceField& field, Normalised& o) {
  const int stride = std::max(1, int(0.05 * o.size / field.spacing()));
  o.nodes.spacing = stride * field.spacing() / o.size;
  o.nodes.origin = (field.nodePosition(0, 0, 0) - o.moments.centroid) / o.size;
  const auto& n = field.size();
  for (int a = 0; a < 3; ++a) o.nodes.size[a] = (n[a] - 1 + stride - 1) / stride + 1;
  o.distance.resize(o.nodes.count());
  const auto last = [&](int i, int a) { return std::min(i * stride, n[a] - 1); };
  for (int z = 0; z < o.nodes.size[2]; ++z)
    for (int y = 0; y < o.nodes.size[1]; ++y)
      for (int x = 0; x < o.nodes.size[0]; ++x)
        o.distance[o.nodes.index(x, y, z)] =
            float(field.nodeDistance(last(x, 0), last(y, 1), last(z, 2)) / o.size);
}

Normalised normalise(const DistanceField& field) {
  Normalised o{&field, insideMoments(field), 1, {}, 1, {}, {}};
  o.size = std::cbrt(o.moments.volume);
  takeNodes(field, o);
  constexpr double kPoints = 3000;
  const double cells = o.moments.volume / std::pow(field.spacing(), 3);
  const int stride = std::max(1, int(std::cbrt(cells / kPoints)));
  const auto& n = field.size();
  for (int z = 0; z < n[2]; z += stride)
    for (int y = 0; y < n[1]; y += stride)
      for (int x = 0; x < n[0]; x += stride)
        if (field.nodeDistance(x, y, z) < 0)
          o.points.emplace_back((field.nodePosition(x, y, z) - o.moments.centroid) / o.size);
  if (o.points.empty()) o.points.emplace_back(0.f);
  o.self = std::max(shareInside(o, o, Mat3d::identity()), 1e-3);
  return o;
}

Mat3d halfOf(const Mat3d& rotation) { return rotationFromVector(0.5 * rotationVector(rotation)); }

/// Intersection over union of a, turned by `rotation`, and b; symmetric.
double overlapOf(const Normalised& a, const Normalised& b, const Mat3d& rotation) {
  const double dice =
      0.5 * (shareInside(a, b, rotation) / a.self + shareInside(b, a, rotation.transpose()) / b.self);
  return dice / std::max(2 - dice, 1e-3);
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

/// The rotation of least angle that takes one direction to another; for opposite directions an arbitrary one.
Mat3d smallestTurn(const Vec3d& from, const Vec3d& to) {
  const Vec3d axis = from.cross(to);
  const double s = axis.length(), c = from.dot(to);
  if (s < 1e-9) {
    if (c > 0) return Mat3d::identity();
    Vec3d side = std::abs(from[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    return rotationFromVector(from.cross(side).unit() * M_PI);
  }
  return rotationFromVector(axis / s * std::atan2(s, c));
}

/// Two objects and what their turns are judged by.
struct Overlaps {
  const Normalised &a, &b;
  double price;  ///< overlap that a turn of 90 degrees must gain

  Turn measured(const Mat3d& rotation) const {
    return {rotation, angleOf(rotation), overlapOf(a, b, rotation)};
  }
  double score(const Turn& t) const { return t.overlap - price * t.angle / (M_PI / 2); }
};

/// Coordinate ascent over small turns about three axes, from steps of `coarse` to steps of `fine` radians.
Turn climbed(const Overlaps& pair, const Turn& start, double coarse, double fine) {
  return climbRotation(
      start, coarse, fine, [&](const Mat3d& rotation) { return pair.measured(rotation); },
      [&](const Turn& t) { return pair.score(t); }, [](const Turn&, double step) { return 1e-3 * step; });
}

/// The result of a climb from `start` if it is clearly better, else `start`.
Turn refined(const Overlaps& pair, const Turn& start, double step) {
  const Turn best = climbed(pair, start, step, 0.008);
  return pair.score(best) > pair.score(start) + kTurnMargin ? best : start;
}

/// All turns that the principal axes suggest, with their overlaps; no turn comes first, the others by score.
std::vector<Turn> suggestedTurns(const Overlaps& pair) {
  const PrincipalAxes pa = principalAxes(pair.a.moments.covariance),
                      pb = principalAxes(pair.b.moments.covariance);
  std::vector<Mat3d> rotations{Mat3d::identity()};
  for (const Mat3d& p : properAxisAssignments()) rotations.push_back(pb.axes * p * pa.axes.transpose());
  for (double sign : {1.0, -1.0})
    rotations.push_back(smallestTurn(column(pa.axes, 0), sign * column(pb.axes, 0)));
  std::vector<Turn> turns(rotations.size());
  tbb::parallel_for(size_t(0), turns.size(), [&](size_t i) { turns[i] = pair.measured(rotations[i]); });
  std::stable_sort(turns.begin() + 1, turns.end(),
                   [&](const Turn& x, const Turn& y) { return pair.score(x) > pair.score(y); });
  return turns;
}

/// Refines the rotation between nearly equal shapes by ICP in both directions [BM92], [Kab76]. About an axis
/// of symmetry the start is kept.
Mat3d fitted(const Normalised& a, const Normalised& b, Mat3d rotation) {
  const auto surface = [](const Normalised& o) {
    std::vector<Vec3d> points;
    for (const SurfaceSample& s : o.field->samples())
      points.push_back((s.position - o.moments.centroid) / o.size);
    return points;
  };
  const auto closest = [](const Normalised& o, const Vec3d& n) {
    return (o.field->closest(o.moments.centroid + o.size * n) - o.moments.centroid) / o.size;
  };
  const std::vector<Vec3d> pa = surface(a), pb = surface(b);
  for (int i = 0; i < 40; ++i) {
    std::vector<Vec3d> from = pa, to;
    for (const Vec3d& p : pa) to.push_back(closest(b, rotation * p));
    for (const Vec3d& p : pb) from.push_back(closest(a, rotation.transpose() * p)), to.push_back(p);
    const Mat3d next = rotationOnto(from, to);
    const double moved = angleOf(next * rotation.transpose());
    rotation = next;
    if (moved < 1e-6) break;
  }
  return rotation;
}

/// A turn refined until converged, so that noise in the shapes changes it as little as the shapes.
Turn polished(const Overlaps& pair, const Turn& turn) {
  const Turn best = climbed(pair, turn, 0.016, 0.0002);
  return best.overlap > kSameShape ? pair.measured(fitted(pair.a, pair.b, best.rotation)) : best;
}

struct Extent {
  double low, high;
};

/// Extent of the inside along a direction, from the coarse nodes and their distances.
Extent extentAlong(const DistanceField& field, const Vec3d& direction) {
  Extent e{1e300, -1e300};
  const auto& n = field.size();
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        const double inside = -field.nodeDistance(x, y, z);
        if (inside < 0) continue;
        const double d = field.nodePosition(x, y, z).dot(direction);
        e.low = std::min(e.low, d - inside), e.high = std::max(e.high, d + inside);
      }
  return e;
}

/// Axes (columns) shared by all objects, in the directions half way between them: the principal axes of
/// the pooled covariance, or the world's axes where its variances are nearly equal. `axis`: prescribed
/// spine direction, or zero.
Mat3d sharedAxes(const std::vector<Normalised>& objects, const std::vector<Mat3d>& rotations,
                 const Vec3d& axis) {
  Mat3d pooled = Mat3d::zero();
  for (size_t k = 0; k < objects.size(); ++k)
    pooled += rotations[k].transpose() * objects[k].moments.covariance * rotations[k] *
              (1.0 / (objects[k].size * objects[k].size));
  PrincipalAxes p = principalAxes(pooled);
  // Variances are nearly equal below this ratio; by hand, guarded by Morph.NoiseDoesNotTurnARoundShape.
  constexpr double kRound = 1.15;
  Vec3d e0 = column(p.axes, 0);
  if (p.variances[0] < kRound * p.variances[1]) {
    // No single longest direction: take the first world axis of nearly the largest extent.
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

/// The same chart for all objects, so that world positions and directions are kept.
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
  frames.halfLength =
      0.5 * box.extents().dot(Vec3d(std::abs(axes(0, 0)), std::abs(axes(1, 0)), std::abs(axes(2, 0)))) / size;
  frames.notes.push_back(
      {"frame.world", Severity::kNote, "", "positions and directions kept as they are in the world"});
  return frames;
}

}  // namespace

std::vector<Turn> proposeTurns(const DistanceField& fieldA, const DistanceField& fieldB, const Vec3d& up) {
  const Normalised a = normalise(fieldA), b = normalise(fieldB);
  // Where nothing is upright, directions in the world mean nothing: only of equals the one that keeps them is taken.
  const bool anyhow = !(up.length() > 0);
  const Overlaps pair{a, b, anyhow ? 0 : kSmallPrice};
  const std::vector<Turn> suggested = suggestedTurns(pair);
  std::vector<Turn> turns(suggested.begin(), suggested.begin() + long(std::min<size_t>(suggested.size(), 9)));
  const Turn world = turns[0];
  tbb::parallel_for(size_t(1), turns.size(), [&](size_t i) {
    turns[i] = refined(pair, turns[i], turns[i].overlap < 0.9 ? 0.3 : 0.08);
  });
  // A tie between symmetric turns is broken by the spine's direction half way; any rule would do that gives
  // the same when the objects are swapped.
  const Vec3d spine = column(principalAxes(a.moments.covariance).axes, 0);
  const auto leaning = [&](const Turn& t) {
    const Vec3d m = halfOf(t.rotation) * spine;
    return std::abs(m[0] + m[1] + m[2]);
  };
  const Turn* best = &turns[0];
  for (const Turn& t : turns)
    if (t.overlap > kSameShape && best->overlap > kSameShape
            ? pair.score(t) > pair.score(*best) + kTie ||
                  (pair.score(t) > pair.score(*best) - kTie && leaning(t) > leaning(*best) + 1e-3)
            : pair.score(t) > pair.score(*best))
      best = &t;
  const bool worldIsAsGood = pair.score(*best) < world.overlap + (anyhow ? kTie : kTurnMargin);
  if (worldIsAsGood && world.overlap > kSureOverlap) return {world};
  if (best->overlap > kDecisive && best->overlap > world.overlap + kDecisiveGain)
    return {polished(pair, *best)};
  std::vector<Turn> worthTrying{world, *best};
  std::stable_sort(turns.begin() + 1, turns.end(),
                   [&](const Turn& x, const Turn& y) { return pair.score(x) > pair.score(y); });
  for (size_t i = 1; i < turns.size() && worthTrying.size() <= kTurnsWorthTrying; ++i) {
    bool fresh = turns[i].overlap > 0.75 * best->overlap;
    for (const Turn& t : worthTrying)
      fresh &= angleOf(turns[i].rotation * t.rotation.transpose()) > kSameTurn;
    if (fresh) worthTrying.push_back(turns[i]);
  }
  tbb::parallel_for(size_t(1), worthTrying.size(),
                    [&](size_t i) { worthTrying[i] = polished(pair, worthTrying[i]); });
  // Models mostly stand upright but face different directions.
  for (int quarter = 1; quarter < 4 && up.length() > 0; ++quarter)
    worthTrying.push_back(pair.measured(rotationFromVector(quarter * M_PI / 2 * up.unit())));
  // Overlap alone misleads where shapes differ: the others may fit better by what lies inside.
  for (const Turn& turn : suggested)
    if (std::none_of(worthTrying.begin(), worthTrying.end(), [&](const Turn& t) {
          return angleOf(turn.rotation * t.rotation.transpose()) < kSameTurn;
        }))
      worthTrying.push_back({turn.rotation, turn.angle, turn.overlap, false});
  return worthTrying;
}

double priceOf(const Mat3d& rotation, const Vec3d& up) {
  // Up to half a degree the margin is charged in proportion, so that the price is continuous.
  constexpr double kNoTurn = 0.5 * M_PI / 180;
  const Vec3d turn = rotationVector(rotation);
  const double angle = turn.length(), both = angle * up.length();
  const double upright = both > 0 ? std::abs(turn.dot(up)) / both : 0;
  // Turns whose axis is within 8 degrees (cosine 0.99) of `up` are upright; the share falls
  // to 0 at 11 degrees.
  const double share = std::min(std::max((upright - 0.98) / 0.01, 0.0), 1.0);
  const double perRightAngle =
      kPricePerRightAngle + share * (kUprightPricePerRightAngle - kPricePerRightAngle);
  return kTurnMargin * std::min(angle / kNoTurn, 1.0) + perRightAngle * angle / (M_PI / 2);
}

Frames frameObjects(const Fields& fields, const std::vector<Mat3d>& turns, const MorphOptions& options) {
  std::vector<Normalised> objects(fields.size());
  tbb::parallel_for(size_t(0), fields.size(), [&](size_t k) { objects[k] = normalise(*fields[k]); });
  if (options.align == Align::kNone) return worldFrames(objects, options.axis);

  // Work in the directions half way between all objects, so that no object is special.
  std::vector<Chart> turned(fields.size());
  for (size_t k = 0; k < fields.size(); ++k) turned[k].axes = turns[k];
  const Mat3d middle = blendCharts(turned, Weights(fields.size(), 1.0 / double(fields.size()))).axes;
  std::vector<Mat3d> rotations;
  rotations.reserve(turns.size());
  for (const Mat3d& turn : turns) rotations.push_back(turn * middle.transpose());
  const Mat3d shared = sharedAxes(objects, rotations, rotations[0].transpose() * options.axis);
  std::vector<double> lengths(fields.size()), radii(fields.size());
  double aspect = 0;
  Frames frames;
  frames.charts.resize(fields.size());
  for (size_t k = 0; k < fields.size(); ++k) {
    Chart& chart = frames.charts[k];
    chart.axes = rotations[k] * shared;
    const Vec3d spine = column(chart.axes, 0);
    const Extent e = extentAlong(*fields[k], spine);
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

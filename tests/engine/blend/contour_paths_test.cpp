// Paths of polygons between polygons: rigid motions, sizes and directions in closed form.
#include "engine/blend/contour_paths.h"
#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

using openvdb::Vec2d;
using Polygon = std::vector<Vec2d>;

constexpr int kCorners = 30;

Vec2d spun(const Vec2d& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p[0] - s * p[1], s * p[0] + c * p[1]};
}

/// Not convex, and of no symmetry.
Polygon bean() {
  Polygon p;
  for (int i = 0; i < kCorners; ++i) {
    const double phase = 2 * M_PI * i / kCorners, r = 1 + 0.4 * std::cos(2 * phase) + 0.2 * std::sin(phase);
    p.push_back(r * Vec2d(std::cos(phase), std::sin(phase)));
  }
  return p;
}

Polygon placed(Polygon p, double angle, const Vec2d& offset, double size = 1) {
  for (Vec2d& q : p) q = size * spun(q, angle) + offset;
  return p;
}

double farthest(const Polygon& a, const Polygon& b) {
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b[i]).length());
  return most;
}

TEST(ContourPaths, EndsAreThePolygonsThemselves) {
  const std::vector<Polygon> polygons{bean(), placed(bean(), 0.8, {2, 1}, 0.5), placed(bean(), -1, {0, 3})};
  for (size_t k = 0; k < 3; ++k) {
    Weights w(3, 0);
    w[k] = 1;
    EXPECT_LE(farthest(intrinsicBlend(polygons, w), polygons[k]), 1e-9) << k;
    EXPECT_LE(farthest(hermiteBlend(polygons, w), polygons[k]), 1e-12) << k;
  }
}

/// A polygon that rotates and moves keeps its shape: it is rotated as the linear mean of its points is, about
/// a centroid that moves in a straight line. The linear mean itself would shrink.
TEST(ContourPaths, IntrinsicPathsKeepShapes) {
  const double angle = 1.9;
  const Vec2d shift(3, -1);
  Vec2d middle(0.0);
  for (const Vec2d& p : bean()) middle += p / double(kCorners);
  const auto about = [&](double a, const Vec2d& to) {
    return placed(placed(bean(), 0, -middle), a, middle + to);
  };
  for (double t : {0.25, 0.5, 0.9}) {
    // The argument of (1 - t) + t e^(i angle); at t = 1/2 half the angle.
    const double turned = std::atan2(t * std::sin(angle), 1 - t + t * std::cos(angle));
    EXPECT_LE(farthest(intrinsicBlend({bean(), about(angle, shift)}, {1 - t, t}), about(turned, t * shift)),
              1e-9)
        << t;
  }
}

TEST(ContourPaths, IntrinsicPathsScale) {
  EXPECT_LE(farthest(intrinsicBlend({bean(), placed(bean(), 0, {0, 0}, 3)}, {0.5, 0.5}),
                     placed(bean(), 0, {0, 0}, 2)),
            1e-9);
}

double turnAt(const Polygon& p, size_t i) {
  const size_t n = p.size();
  const Vec2d before = p[i] - p[(i + n - 1) % n], after = p[(i + 1) % n] - p[i];
  return std::atan2(before[0] * after[1] - before[1] * after[0], before.dot(after));
}

/// Polygons are closed by changing lengths only: the turning angle at every corner, the last ones included,
/// is the mean of the polygons' angles.
TEST(ContourPaths, IntrinsicBlendsAreClosedByTheirLengths) {
  const Polygon square{{0, 0}, {2, 0}, {2, 2}, {0, 2}}, kite{{0, 0}, {2, 0}, {1.2, 2}, {0.5, 1.5}};
  for (double t : {0.3, 0.5, 0.8}) {
    const Polygon blend = intrinsicBlend({square, kite}, {1 - t, t});
    for (size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(turnAt(blend, i), (1 - t) * turnAt(square, i) + t * turnAt(kite, i), 1e-9)
          << t << " corner " << i;
  }
}

/// Lengths change by no more than closing requires. Here: a square and a triangle of four points.
TEST(ContourPaths, IntrinsicBlendsKeepTheirLengths) {
  const Polygon square{{0, 0}, {2, 0}, {2, 2}, {0, 2}}, triangle{{0, 0}, {2, 0}, {1, 2}, {0.5, 1}};
  const Polygon half = intrinsicBlend({square, triangle}, {0.5, 0.5});
  for (size_t i = 0; i < 4; ++i) {
    const Vec2d edge = half[(i + 1) % 4] - half[i];
    const double a = (square[(i + 1) % 4] - square[i]).length(),
                 b = (triangle[(i + 1) % 4] - triangle[i]).length();
    EXPECT_GT(edge.length(), 0.5 * std::min(a, b)) << i;
    EXPECT_LT(edge.length(), 1.5 * std::max(a, b)) << i;
  }
}

/// Points leave each polygon at right angles: the path's initial direction has no component along the chord
/// between a point's neighbours.
TEST(ContourPaths, HermitePathsLeaveAtRightAngles) {
  const std::vector<Polygon> polygons{bean(), placed(bean(), 0.7, {1.5, 0.4}, 1.3)};
  constexpr double kStep = 1e-6;
  for (int end = 0; end < 2; ++end) {
    const Polygon& own = polygons[size_t(end)];
    const Weights w = end == 0 ? Weights{1 - kStep, kStep} : Weights{kStep, 1 - kStep};
    const Polygon moved = hermiteBlend(polygons, w);
    for (size_t i = 0; i < kCorners; ++i) {
      const Vec2d along = own[(i + 1) % kCorners] - own[(i + kCorners - 1) % kCorners];
      const Vec2d speed = (moved[i] - own[i]) / kStep;
      EXPECT_NEAR(speed.dot(along) / along.length(), 0, 1e-4) << i;
      // Across the chord it is as fast as the linear path.
      const Vec2d across = spun(along / along.length(), M_PI / 2);
      EXPECT_NEAR(speed.dot(across), (polygons[size_t(1 - end)][i] - own[i]).dot(across), 1e-4) << i;
    }
  }
}

/// A rod turned about its spine in opposite directions on the two objects: half way, the linear mean of its
/// points is thinner by the cosine of the angle, and the offsets restore that.
TEST(ContourPaths, OffsetsUndoTheShrinking) {
  const double angle = M_PI / 4, radius = 0.5;
  const Fields fields(2,
                      shapes::fieldOf(shapes::capsule({-0.8, 0, 0}, {0.8, 0, 0}, radius),
                                      openvdb::BBoxd(Vec3d(-1.4, -0.6, -0.6), Vec3d(1.4, 0.6, 0.6)), 0.05));
  const std::vector<Chart> charts(2, shapes::straightChart());
  const Lattice lattice = Lattice::over({Vec3d(-1.8, -1, -1), Vec3d(1.8, 1, 1)}, 0.1);
  // The middle space has the mean of the turned positions.
  const double shrunk = std::cos(angle);
  Displacements map{lattice, std::vector<VectorField>(2, VectorField(lattice.count()))};
  for (int z = 0; z < lattice.size[2]; ++z)
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const Vec3d s = lattice.position(x, y, z);
        for (int k = 0; k < 2; ++k) {
          const Vec2d p = spun({s[1] / shrunk, s[2] / shrunk}, k == 0 ? angle : -angle);
          map.of[size_t(k)][lattice.index(x, y, z)] = openvdb::Vec3s(Vec3d(0, p[0] - s[1], p[1] - s[2]));
        }
      }
  const ContourPaths paths(ContourPath::kIntrinsic, map, fields, charts, 16);
  for (const Weights& w : {Weights{1, 0}, Weights{0, 1}})
    for (const openvdb::Vec3s& v : paths.offsets(w, lattice)) ASSERT_LE(v.length(), 1e-5f);
  const VectorField offsets = paths.offsets({0.5, 0.5}, lattice);
  for (int i = 0; i < 12; ++i) {
    const Vec2d out(std::cos(i * M_PI / 6), std::sin(i * M_PI / 6));
    const Vec3d s(0, shrunk * radius * out[0], shrunk * radius * out[1]);
    const Vec3d wanted = (1 / shrunk - 1) * Vec3d(0, s[1], s[2]);
    // The offsets are fitted and so smoothed: a tenth may be missing.
    EXPECT_LE((sampleField(lattice, offsets, s) - wanted).length(), 0.1 * wanted.length()) << i;
  }
}

}  // namespace
}  // namespace slicemorph

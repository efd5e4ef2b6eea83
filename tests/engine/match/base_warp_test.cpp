// Slices of ellipses, whose covariances and square roots have closed forms.
#include "engine/match/base_warp.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr int kSlices = 24, kCorners = 720;

/// Half axes a and b, the first turned by `angle` from x.
struct Ellipse {
  Vec2d middle{0, 0};
  double a = 1, b = 1, angle = 0;

  Vec2d at(double phase) const {
    const double x = a * std::cos(phase), y = b * std::sin(phase), c = std::cos(angle), s = std::sin(angle);
    return middle + Vec2d(c * x - s * y, s * x + c * y);
  }
  std::vector<Contour> contours() const {
    Contour contour;
    for (int i = 0; i < kCorners; ++i) contour.points.push_back(at(2 * M_PI * i / kCorners));
    contour.area = M_PI * a * b, contour.centroid = middle;
    return {contour};
  }
  /// The symmetric square root of its covariance, with the half axes a / 2 and b / 2 on its own axes.
  SliceAffine root() const {
    const double c = std::cos(angle), s = std::sin(angle);
    return {middle, 0.5 * (a * c * c + b * s * s), 0.5 * (a - b) * c * s, 0.5 * (a * s * s + b * c * c)};
  }
};

/// Polygons of 720 corners lack about (2 pi / 720)^2 / 6 of their area, and as much of their moments.
constexpr double kPolygon = 1e-4;

SlicePlanes planes() {
  SlicePlanes p;
  for (int i = 0; i < kSlices; ++i) p.z0.push_back(-1.2 + 0.1 * i);
  return p;
}

std::vector<ContourStack> stacksOf(const std::vector<Ellipse>& ellipses) {
  std::vector<ContourStack> stacks;
  for (const Ellipse& e : ellipses) stacks.emplace_back(kSlices, e.contours());
  return stacks;
}

BaseWarp warpOf(const std::vector<ContourStack>& stacks) {
  return makeBaseWarp(stacks, planes(), std::vector<std::vector<double>>(stacks.size(), planes().z0));
}

void expectSame(const SliceAffine& found, const SliceAffine& wanted, double tolerance) {
  EXPECT_LE((found.mean - wanted.mean).length(), tolerance);
  EXPECT_NEAR(found.xx, wanted.xx, tolerance);
  EXPECT_NEAR(found.xy, wanted.xy, tolerance);
  EXPECT_NEAR(found.yy, wanted.yy, tolerance);
}

SliceAffine meanOf(const SliceAffine& p, const SliceAffine& q) {
  return {0.5 * (p.mean + q.mean), 0.5 * (p.xx + q.xx), 0.5 * (p.xy + q.xy), 0.5 * (p.yy + q.yy)};
}

const Ellipse kFirst{{0.3, -0.2}, 1.1, 0.6, 0.4}, kSecond{{-0.1, 0.5}, 0.8, 0.7, -0.9};

TEST(BaseWarp, RootsAreThoseOfTheEllipses) {
  const BaseWarp base = warpOf(stacksOf({kFirst, kSecond}));
  for (size_t i = 0; i < kSlices; ++i) {
    expectSame(base.objects[0][i], kFirst.root(), kPolygon);
    expectSame(base.objects[1][i], kSecond.root(), kPolygon);
    expectSame(base.middle[i], meanOf(kFirst.root(), kSecond.root()), kPolygon);
  }
}

/// Both ellipses go onto that of the mean root, the phase measured where their roots lead: points with the
/// same root^-1 (p - mean) meet.
TEST(BaseWarp, ContoursMeetInTheMiddle) {
  const BaseWarp base = warpOf(stacksOf({kFirst, kSecond}));
  const SliceAffine m = meanOf(kFirst.root(), kSecond.root());
  for (int i = 0; i < 16; ++i) {
    const Vec2d q(2 * std::cos(i), 2 * std::sin(i));
    const auto onto = [&](const SliceAffine& r) {
      return r.mean + Vec2d(r.xx * q[0] + r.xy * q[1], r.xy * q[0] + r.yy * q[1]);
    };
    EXPECT_LE((toMiddle(base, 0, 7, onto(kFirst.root())) - onto(m)).length(), 10 * kPolygon);
    EXPECT_LE((toMiddle(base, 1, 7, onto(kSecond.root())) - onto(m)).length(), 10 * kPolygon);
  }
}

/// Between two parts of an object the values change as its convolution with a Gaussian of four slices.
TEST(BaseWarp, IsSmoothedOverFourSlices) {
  std::vector<ContourStack> stacks = stacksOf({kFirst, kFirst});
  Ellipse moved = kFirst;
  moved.middle[0] += 1;
  for (int i = kSlices / 2; i < kSlices; ++i) stacks[0][size_t(i)] = moved.contours();
  const BaseWarp base = warpOf(stacks);
  for (int i = 0; i < kSlices; ++i) {
    double sum = 0, all = 0;
    for (int j = 0; j < kSlices; ++j) {
      const double w = std::exp(-0.5 * (i - j) * (i - j) / 16.0);
      all += w, sum += j < kSlices / 2 ? 0 : w;
    }
    EXPECT_NEAR(base.objects[0][size_t(i)].mean[0], kFirst.middle[0] + sum / all, 1e-6) << i;
  }
}

TEST(BaseWarp, EmptySlicesTakeTheirNeighbours) {
  std::vector<ContourStack> stacks = stacksOf({kFirst, kSecond});
  for (int i = 0; i < 10; ++i) stacks[0][size_t(i)].clear(), stacks[0][size_t(kSlices - 1 - i)].clear();
  const BaseWarp base = warpOf(stacks);
  for (size_t i = 0; i < kSlices; ++i) expectSame(base.objects[0][i], kFirst.root(), kPolygon);
}

/// No slice is stretched by more than 1.8 to the middle.
TEST(BaseWarp, StretchesAreBounded) {
  const Ellipse small{{0, 0}, 0.1, 0.1, 0}, large{{0, 0}, 2, 2, 0};
  const BaseWarp base = warpOf(stacksOf({small, large}));
  const double middle = base.middle[3].xx;
  EXPECT_NEAR(middle, 0.525, kPolygon);
  EXPECT_NEAR(base.objects[0][3].xx, middle / 1.8, kPolygon);
  EXPECT_NEAR(base.objects[1][3].xx, middle * 1.8, kPolygon);
}

/// Inside the box every object has a lattice's node where its root carries it, the sum over the objects taken
/// away; from there to the rim it fades linearly to nothing.
TEST(BaseWarp, DisplacementsAreTheAffineMaps) {
  std::vector<std::vector<double>> position(2, planes().z0);
  for (double& z : position[0]) z += 0.03 * (1.2 + z);
  for (double& z : position[1]) z -= 0.03 * (1.2 + z);
  const BaseWarp base = makeBaseWarp(stacksOf({kFirst, kSecond}), planes(), position);
  const openvdb::BBoxd box(Vec3d(-1.2, -1, -1), Vec3d(1.1, 1, 1));
  const double margin = 0.4;
  const Lattice lattice = Lattice::over({box.min() - Vec3d(margin), box.max() + Vec3d(margin)}, 0.1);
  const Displacements map = baseDisplacements(base, lattice, box);
  const SliceAffine m = meanOf(kFirst.root(), kSecond.root());
  const double det = m.xx * m.yy - m.xy * m.xy;
  for (int z = 0; z < lattice.size[2]; ++z)
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const Vec3d s = lattice.position(x, y, z);
        double fade = 1;
        for (int a = 0; a < 3; ++a)
          fade *= std::max(0.0, 1 - std::max({0.0, box.min()[a] - s[a], s[a] - box.max()[a]}) /
                                        (box.min()[a] - lattice.origin[a]));
        const Vec2d d = Vec2d(s[1], s[2]) - m.mean;
        const Vec2d q((m.yy * d[0] - m.xy * d[1]) / det, (m.xx * d[1] - m.xy * d[0]) / det);
        // Two objects' roots have the middle's as their mean: the displacements sum to nothing by themselves.
        int sign = 1;
        for (const Ellipse& e : {kFirst, kSecond}) {
          const SliceAffine r = e.root();
          const Vec2d at = r.mean + Vec2d(r.xx * q[0] + r.xy * q[1], r.xy * q[0] + r.yy * q[1]);
          const double z0 = std::min(std::max(s[0], -1.2), 1.1);
          const Vec3d wanted = fade * Vec3d(sign * 0.03 * (1.2 + z0), at[0] - s[1], at[1] - s[2]);
          const Vec3d found(map.of[sign > 0 ? 0 : 1][lattice.index(x, y, z)]);
          ASSERT_LE((found - wanted).length(), 20 * kPolygon) << s;
          sign = -1;
        }
      }
}

}  // namespace
}  // namespace slicemorph

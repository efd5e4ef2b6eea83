// Contours of images with a known answer, and of random images against flood fill and winding numbers.
#include "engine/contours/contours.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace slicemorph {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;

SlicePlanes planesOf(int nx, int ny, double pixel, const Vec2d& origin) {
  SlicePlanes planes;
  planes.nx = nx, planes.ny = ny, planes.pixel = pixel, planes.origin = origin;
  return planes;
}

SliceImage imageOf(const SlicePlanes& planes, const std::function<double(const Vec2d&)>& f) {
  SliceImage image;
  for (int y = 0; y < planes.ny; ++y)
    for (int x = 0; x < planes.nx; ++x) image.push_back(float(f(planes.origin + planes.pixel * Vec2d(x, y))));
  return image;
}

double lengthOf(const Contour& c) {
  double length = 0;
  for (size_t i = 0; i < c.points.size(); ++i)
    length += (c.points[(i + 1) % c.points.size()] - c.points[i]).length();
  return length;
}

Contour polygon(std::vector<Vec2d> points, double area) {
  Contour c;
  c.points = std::move(points), c.area = area;
  return c;
}

/// Corners of a rectangle, counter-clockwise; of a hole clockwise.
Contour rectangle(const Vec2d& low, const Vec2d& high, bool hole = false) {
  std::vector<Vec2d> p{low, {high[0], low[1]}, high, {low[0], high[1]}};
  if (hole) std::reverse(p.begin(), p.end());
  const double area = (high[0] - low[0]) * (high[1] - low[1]);
  return polygon(std::move(p), hole ? -area : area);
}

/// Winding number of a polygon about a point, counter-clockwise, by summing angles.
int windingOf(const Contour& c, const Vec2d& p) {
  double angle = 0;
  for (size_t i = 0; i < c.points.size(); ++i) {
    const Vec2d a = c.points[i] - p, b = c.points[(i + 1) % c.points.size()] - p;
    angle += std::atan2(a[0] * b[1] - a[1] * b[0], a.dot(b));
  }
  return int(std::lround(angle / kTwoPi));
}

TEST(Contours, ACircleHasItsAreaAndLength) {
  const double r = 0.83, h = 0.05;
  const Vec2d middle(0.21, -0.13);
  const SlicePlanes planes = planesOf(61, 57, h, {-1.3, -1.4});
  const auto contours =
      traceContours(imageOf(planes, [&](const Vec2d& p) { return (p - middle).length() - r; }), planes);
  ASSERT_EQ(contours.size(), 1u);
  const Contour& c = contours[0];
  // A distance bends by at most 1 / (r - h) along an edge: its crossing is off by at most e = h^2 / 8 (r -
  // h); chords of at most sqrt 2 pixels lie up to s = h^2 / 4 r inside.
  const double e = h * h / 8 / (r - h), s = h * h / 4 / r;
  for (const Vec2d& p : c.points) EXPECT_NEAR((p - middle).length(), r, 1.5 * e);
  EXPECT_GT(c.area, 0);
  EXPECT_NEAR(c.area, M_PI * r * r, kTwoPi * r * (e + s));
  EXPECT_NEAR(lengthOf(c), kTwoPi * r, kTwoPi * (e + s) + 1e-2 * h);
  EXPECT_LE((c.centroid - middle).length(), e + s);
  EXPECT_EQ(c.parent, -1);
}

/// A disc in the hole of a ring: outer contours counter-clockwise, holes clockwise, each with
/// the right parent.
TEST(Contours, RingsAreNested) {
  const SlicePlanes planes = planesOf(90, 90, 0.03, {-1.3, -1.3});
  const auto contours = traceContours(imageOf(planes,
                                              [](const Vec2d& p) {
                                                const double r = p.length();
                                                return std::min(std::abs(r - 0.8) - 0.2, r - 0.3);
                                              }),
                                      planes);
  ASSERT_EQ(contours.size(), 3u);
  int outer = -1, hole = -1, disc = -1;
  for (int i = 0; i < 3; ++i)
    (contours[size_t(i)].hole() ? hole : contours[size_t(i)].area > 2 ? outer : disc) = i;
  ASSERT_TRUE(outer >= 0 && hole >= 0 && disc >= 0);
  EXPECT_NEAR(contours[size_t(outer)].area, M_PI, 0.01);
  EXPECT_NEAR(contours[size_t(hole)].area, -M_PI * 0.36, 0.01);
  EXPECT_NEAR(contours[size_t(disc)].area, M_PI * 0.09, 0.01);
  EXPECT_EQ(contours[size_t(outer)].parent, -1);
  EXPECT_EQ(contours[size_t(hole)].parent, outer);
  EXPECT_EQ(contours[size_t(disc)].parent, hole);
}

TEST(Contours, SpecksAndWhatTheBorderCutsAreDropped) {
  const SlicePlanes planes = planesOf(30, 30, 1, {0, 0});
  const auto discs = [&](double r, const Vec2d& at) {
    return traceContours(imageOf(planes, [&](const Vec2d& p) { return (p - at).length() - r; }), planes);
  };
  EXPECT_EQ(discs(1.05, {15, 15}).size(), 0u);  // 3.5 pixels
  EXPECT_EQ(discs(1.3, {15, 15}).size(), 1u);   // 5.3 pixels
  EXPECT_EQ(discs(4, {1, 15}).size(), 0u);
}

/// Two squares that touch at a corner's cell: the value at its centre decides whether they are one.
TEST(Contours, TheCentreDecidesAmbiguousCells) {
  const SlicePlanes planes = planesOf(12, 12, 1, {0, 0});
  for (bool mirrored : {false, true})
    for (double corner : {-2.0, -0.5}) {
      const auto contours = traceContours(imageOf(planes,
                                                  [&](const Vec2d& q) {
                                                    const double x = mirrored ? 11 - q[0] : q[0], y = q[1];
                                                    const bool low = x >= 2 && x <= 5 && y >= 2 && y <= 5;
                                                    const bool high = x >= 6 && x <= 9 && y >= 6 && y <= 9;
                                                    if (!low && !high) return 1.0;
                                                    const bool touches =
                                                        (x == 5 && y == 5) || (x == 6 && y == 6);
                                                    return touches ? corner : -1.0;
                                                  }),
                                          planes);
      EXPECT_EQ(contours.size(), corner < -1 ? 1u : 2u) << corner << (mirrored ? " mirrored" : "");
    }
}

/// Pixels by the signs of random blocks, which meet at corners everywhere.
class RandomImage {
 public:
  static constexpr int kBlock = 4, kBlocks = 12, kSide = kBlock * kBlocks;

  explicit RandomImage(unsigned seed) {
    std::mt19937 random(seed);
    std::vector<char> inside(kBlocks * kBlocks, 0);
    for (int y = 1; y + 1 < kBlocks; ++y)
      for (int x = 1; x + 1 < kBlocks; ++x) inside[size_t(y * kBlocks + x)] = random() % 2;
    planes = planesOf(kSide, kSide, 1, {0, 0});
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const float size = std::uniform_real_distribution<float>(0.1f, 1)(random);
        image.push_back(inside[size_t(y / kBlock * kBlocks + x / kBlock)] ? -size : size);
      }
  }

  float at(int x, int y) const { return image[size_t(y * kSide + x)]; }

  /// Parts of the inside or the outside, joined over edges and, by the value at the centre, over corners.
  int parts(bool inside) const {
    std::vector<char> seen(image.size(), 0);
    int count = 0;
    for (int start = 0; start < kSide * kSide; ++start) {
      if (seen[size_t(start)] || (image[size_t(start)] < 0) != inside) continue;
      ++count;
      std::vector<int> front{start};
      seen[size_t(start)] = 1;
      while (!front.empty()) {
        const int x = front.back() % kSide, y = front.back() / kSide;
        front.pop_back();
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const int a = x + dx, b = y + dy, n = b * kSide + a;
            if (a < 0 || b < 0 || a >= kSide || b >= kSide || seen[size_t(n)]) continue;
            if ((at(a, b) < 0) != inside || !joined(x, y, a, b)) continue;
            seen[size_t(n)] = 1;
            front.push_back(n);
          }
      }
    }
    return count;
  }

  SlicePlanes planes;
  SliceImage image;

 private:
  bool joined(int x, int y, int a, int b) const {
    if (x == a || y == b) return true;
    const bool centre = at(x, y) + at(a, y) + at(a, b) + at(x, b) < 0;
    return centre == (at(x, y) < 0);
  }
};

TEST(Contours, AgreeWithFloodFillAndWindingNumbers) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const RandomImage random(seed);
    const auto contours = traceContours(random.image, random.planes);
    int outer = 0, holes = 0;
    for (const Contour& c : contours) ++(c.hole() ? holes : outer);
    EXPECT_EQ(outer, random.parts(true)) << seed;
    EXPECT_EQ(holes, random.parts(false) - 1) << seed;
    for (int y = 0; y < RandomImage::kSide; ++y)
      for (int x = 0; x < RandomImage::kSide; ++x) {
        int winding = 0;
        for (const Contour& c : contours) {
          const int own = windingOf(c, Vec2d(x, y));
          winding += own;
          ASSERT_EQ(contains(c.points, Vec2d(x, y)), own != 0) << seed;
        }
        ASSERT_EQ(winding, random.at(x, y) < 0 ? 1 : 0) << seed << " at " << x << ", " << y;
      }
  }
}

/// The parent is the smallest contour around, and holes and outer contours alternate.
TEST(Contours, ParentsAreTheSmallestAround) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto contours = traceContours(RandomImage(seed).image, RandomImage(seed).planes);
    for (const Contour& c : contours) {
      double least = 1e30;
      int parent = -1;
      for (size_t j = 0; j < contours.size(); ++j) {
        const double area = std::abs(contours[j].area);
        if (&contours[j] != &c && windingOf(contours[j], c.points[0]) != 0 && area < least &&
            area > std::abs(c.area))
          least = area, parent = int(j);
      }
      EXPECT_EQ(c.parent, parent) << seed;
      EXPECT_EQ(c.hole(), parent >= 0 && !contours[size_t(parent)].hole()) << seed;
    }
  }
}

/// A plate with a hole: area, mean and covariance by the parallel axis theorem.
TEST(Contours, MomentsAreThoseOfRectangles) {
  const Vec2d low(1, 2), high(5, 4), holeLow(2, 2.5), holeHigh(3, 3.5);
  const SliceMoments m = momentsOf({rectangle(low, high), rectangle(holeLow, holeHigh, true)});
  const double plate = 8, hole = 1, area = plate - hole;
  const Vec2d mean = (plate * Vec2d(3, 3) - hole * Vec2d(2.5, 3)) / area;
  const auto spread = [&](int a, int b) {
    const Vec2d side = high - low, cut = holeHigh - holeLow, p = Vec2d(3, 3) - mean, q = Vec2d(2.5, 3) - mean;
    const double own = a == b ? plate * side[a] * side[a] / 12 - hole * cut[a] * cut[a] / 12 : 0;
    return (own + plate * p[a] * p[b] - hole * q[a] * q[b]) / area;
  };
  EXPECT_NEAR(m.area, area, 1e-12);
  EXPECT_LE((m.mean - mean).length(), 1e-12);
  EXPECT_NEAR(m.xx, spread(0, 0), 1e-12);
  EXPECT_NEAR(m.xy, spread(0, 1), 1e-12);
  EXPECT_NEAR(m.yy, spread(1, 1), 1e-12);
}

/// A slanted triangle, whose covariance is 1/18 of sum v v^T - sum over pairs: with the corners about the
/// mean, 1/12 of sum v v^T.
TEST(Contours, MomentsAreThoseOfATriangle) {
  const Vec2d v[3] = {{0.3, -1}, {2, 0.5}, {-1, 1.7}};
  const Vec2d a = v[1] - v[0], b = v[2] - v[0], mean = (v[0] + v[1] + v[2]) / 3.0;
  const double area = 0.5 * (a[0] * b[1] - a[1] * b[0]);
  const SliceMoments m = momentsOf({polygon({v[0], v[1], v[2]}, area)});
  double xx = 0, xy = 0, yy = 0;
  for (const Vec2d& p : v) {
    const Vec2d d = p - mean;
    xx += d[0] * d[0] / 12, xy += d[0] * d[1] / 12, yy += d[1] * d[1] / 12;
  }
  EXPECT_NEAR(m.area, area, 1e-12);
  EXPECT_LE((m.mean - mean).length(), 1e-12);
  EXPECT_NEAR(m.xx, xx, 1e-12);
  EXPECT_NEAR(m.xy, xy, 1e-12);
  EXPECT_NEAR(m.yy, yy, 1e-12);
}

TEST(Contours, NothingHasNoMoments) { EXPECT_EQ(momentsOf({}).area, 0); }

/// Twelve points on a square of side 3: every unit of its length, from its first corner on.
TEST(Contours, ResamplingStepsEvenly) {
  const std::vector<Vec2d> points = resample(rectangle({0, 0}, {3, 3}), 12);
  ASSERT_EQ(points.size(), 12u);
  const Vec2d side[4] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  Vec2d wanted(0, 0);
  for (int i = 0; i < 12; ++i) {
    EXPECT_LE((points[size_t(i)] - wanted).length(), 1e-12) << i;
    wanted += side[i / 3];
  }
  // More points than corners, and fewer.
  EXPECT_LE((resample(rectangle({0, 0}, {3, 1}), 2)[1] - Vec2d(3, 1)).length(), 1e-12);
}

}  // namespace
}  // namespace slicemorph

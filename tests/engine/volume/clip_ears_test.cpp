#include "engine/volume/clip_ears.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

using openvdb::Vec3I;
using openvdb::Vec3s;

Vec3d areaVector(const std::vector<Vec3s>& points, const Vec3I& t) {
  const Vec3d a(points[t[0]]);
  return 0.5 * (Vec3d(points[t[1]]) - a).cross(Vec3d(points[t[2]]) - a);
}

/// Star-shaped polygons in a tilted plane do not self-intersect, however jagged: all their triangles face the
/// same way, so their areas, none counted twice, add up to the polygon's.
TEST(ClipEars, CoversStarsOnceAndNothingElse) {
  std::mt19937 random(21);
  const Vec3d e1 = Vec3d(1, 2, -1).unit(), e2 = Vec3d(1, 0, 1).unit(), normal = e1.cross(e2);
  for (int n : {3, 4, 5, 8, 30}) {
    std::vector<Vec3s> points(5, Vec3s(9.f));  // the face does not begin at the first point
    std::vector<std::uint32_t> face;
    double area = 0;
    std::vector<double> radius;
    for (int i = 0; i < n; ++i) radius.push_back(0.3 + double(random() % 1000) / 1000);
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * M_PI * i / n, turn = 2 * M_PI / n;
      face.push_back(std::uint32_t(points.size()));
      points.emplace_back(Vec3s(radius[size_t(i)] * (std::cos(angle) * e1 + std::sin(angle) * e2)));
      area += 0.5 * radius[size_t(i)] * radius[size_t((i + 1) % n)] * std::sin(turn);
    }
    const std::vector<Vec3I> triangles = clipEars(points, face);
    ASSERT_EQ(triangles.size(), size_t(n - 2));
    double sum = 0;
    for (const Vec3I& t : triangles) {
      const double own = areaVector(points, t).dot(normal);
      EXPECT_GT(own, -1e-6) << n;
      sum += own;
    }
    EXPECT_NEAR(sum, area, 1e-5) << n;  // points are single precision
  }
}

TEST(ClipEars, EndsWhereAPolygonCrossesItselfOrIsALine) {
  const std::vector<Vec3s> bow{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(clipEars(bow, {0, 1, 2, 3}).size(), 2u);
  const std::vector<Vec3s> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}};
  EXPECT_EQ(clipEars(line, {0, 1, 2, 3, 4}).size(), 3u);
}

}  // namespace
}  // namespace slicemorph

#include "engine/volume/fill_holes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace slicemorph {
namespace {

using openvdb::Vec3I;
using openvdb::Vec3s;

double areaOf(const std::vector<Vec3s>& points, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const Vec3d p(points[a]);
  return 0.5 * (Vec3d(points[b]) - p).cross(Vec3d(points[c]) - p).length();
}

/// Reference: the least area of all triangulations of the corners first to last of a polygon, by trying each.
double leastArea(const std::vector<Vec3s>& points, const PointLoop& loop, size_t first, size_t last) {
  if (last - first < 2) return 0;
  double least = 1e300;
  for (size_t k = first + 1; k < last; ++k)
    least = std::min(least, leastArea(points, loop, first, k) + leastArea(points, loop, k, last) +
                                areaOf(points, loop[first], loop[k], loop[last]));
  return least;
}

TEST(FillHole, HasTheLeastAreaOfAllTriangulations) {
  std::mt19937 random(31);
  for (size_t n : {3u, 4u, 5u, 8u, 10u})
    for (int sample = 0; sample < 5; ++sample) {
      Mesh mesh;
      PointLoop loop;
      for (size_t i = 0; i < n; ++i) {
        loop.push_back(std::uint32_t(i));
        mesh.points.emplace_back(float(random() % 100), float(random() % 100), float(random() % 100));
      }
      fillHole(mesh, loop);
      ASSERT_EQ(mesh.triangles.size(), n - 2);
      EXPECT_EQ(mesh.points.size(), n);
      double area = 0;
      for (const Vec3I& t : mesh.triangles) area += areaOf(mesh.points, t[0], t[1], t[2]);
      const double least = leastArea(mesh.points, loop, 0, n - 1);
      EXPECT_NEAR(area, least, 1e-9 * least);
      // The boundary of the filling is the loop in reverse.
      const BoundaryLoops boundary = findBoundary(mesh.triangles, n);
      ASSERT_EQ(boundary.loops.size(), 1u);
      EXPECT_EQ(boundary.edges, n);
      PointLoop back = boundary.loops[0];
      std::reverse(back.begin(), back.end());
      std::rotate(back.begin(), std::find(back.begin(), back.end(), 0u), back.end());
      EXPECT_EQ(back, loop);
    }
}

TEST(FillHole, LargeHolesAreFilledAroundTheirMiddle) {
  constexpr std::uint32_t kCorners = 500;
  Mesh mesh;
  PointLoop loop;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const double angle = 2 * M_PI * i / kCorners;
    loop.push_back(i);
    mesh.points.emplace_back(float(std::cos(angle)), float(std::sin(angle)), 0.f);
  }
  fillHole(mesh, loop);
  ASSERT_EQ(mesh.triangles.size(), size_t(kCorners));
  double area = 0;
  for (const Vec3I& t : mesh.triangles) area += areaOf(mesh.points, t[0], t[1], t[2]);
  EXPECT_NEAR(area, 0.5 * kCorners * std::sin(2 * M_PI / kCorners), 1e-5);
  EXPECT_NEAR(loopLength(mesh.points, loop), 2 * kCorners * std::sin(M_PI / kCorners), 1e-4);
}

/// A square sheet of n x n squares, without some of them.
std::vector<Vec3I> sheet(unsigned n, const std::function<bool(unsigned, unsigned)>& hole) {
  std::vector<Vec3I> triangles;
  for (unsigned y = 0; y < n; ++y)
    for (unsigned x = 0; x < n; ++x) {
      if (hole(x, y)) continue;
      const unsigned a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      triangles.emplace_back(a, b, d);
      triangles.emplace_back(a, d, c);
    }
  return triangles;
}

TEST(Boundary, HolesThatMeetInAPointAreTwoLoops) {
  const std::vector<Vec3I> triangles = sheet(6, [](unsigned x, unsigned y) {
    return (x == 2 && y == 2) || (x == 3 && y == 3) || (x == 1 && y == 4);
  });
  const BoundaryLoops boundary = findBoundary(triangles, 49);
  std::vector<size_t> sizes;
  for (const PointLoop& loop : boundary.loops) {
    PointLoop points = loop;
    std::sort(points.begin(), points.end());
    EXPECT_EQ(std::unique(points.begin(), points.end()), points.end()) << "passes a point twice";
    sizes.push_back(loop.size());
  }
  std::sort(sizes.begin(), sizes.end());
  EXPECT_EQ(sizes, (std::vector<size_t>{4, 4, 4, 24}));
  EXPECT_EQ(boundary.edges, 36u);
  EXPECT_EQ(boundary.strays, 0u);
}

TEST(Boundary, PartsAreThoseThatHangTogetherWhateverTheWinding) {
  Mesh mesh;
  for (unsigned y = 0; y < 7; ++y)
    for (unsigned x = 0; x < 7; ++x) mesh.points.emplace_back(float(x), float(y), 0.f);
  mesh.triangles = sheet(6, [](unsigned x, unsigned y) { return x == 2 && y == 2; });
  for (size_t t = 0; t < mesh.triangles.size(); t += 3) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  std::vector<double> lengths = boundaryParts(mesh);
  std::sort(lengths.begin(), lengths.end());
  ASSERT_EQ(lengths.size(), 2u);
  EXPECT_DOUBLE_EQ(lengths[0], 4);
  EXPECT_DOUBLE_EQ(lengths[1], 24);
}

}  // namespace
}  // namespace slicemorph

#include "engine/numerics/edge_table.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace slicemorph {
namespace {

using openvdb::Vec3I;

TEST(EdgeTable, HoldsEverySideOfEveryTriangleOnce) {
  std::mt19937 random(3);
  for (unsigned points : {3u, 5u, 12u, 40u}) {
    std::vector<Vec3I> triangles;
    while (triangles.size() < 2 * points) {
      const Vec3I t(random() % points, random() % points, random() % points);
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    // A map is ordered by points, and each of its lists by triangle.
    std::map<std::pair<unsigned, unsigned>, std::vector<unsigned>> expected;
    for (unsigned corner = 0; corner < 3 * triangles.size(); ++corner) {
      const Vec3I& t = triangles[corner / 3];
      expected[std::minmax(t[int(corner % 3)], t[int((corner + 1) % 3)])].push_back(corner);
    }
    const EdgeTable table(triangles);
    ASSERT_EQ(table.count(), expected.size());
    size_t e = 0;
    for (const auto& [ends, corners] : expected) {
      ASSERT_EQ(table.faces(e), corners.size());
      for (size_t i = 0; i < corners.size(); ++i) {
        const HalfEdge& half = table.half(e, i);
        EXPECT_EQ(half.low, ends.first);
        EXPECT_EQ(half.high, ends.second);
        EXPECT_EQ(half.corner, corners[i]);
        EXPECT_EQ(half.triangle(), corners[i] / 3);
        EXPECT_EQ(half.from(), triangles[corners[i] / 3][int(corners[i] % 3)]);
        EXPECT_EQ(half.to(), triangles[corners[i] / 3][int((corners[i] + 1) % 3)]);
      }
      EXPECT_EQ(table.end(e) - table.begin(e), ptrdiff_t(corners.size()));
      ++e;
    }
  }
}

TEST(EdgeTable, OfATetrahedronHasSixEdgesOfTwoFacesInOppositeDirections) {
  const EdgeTable table({{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
  ASSERT_EQ(table.count(), 6u);
  for (size_t e = 0; e < 6; ++e) {
    ASSERT_EQ(table.faces(e), 2u);
    EXPECT_NE(table.half(e, 0).forward, table.half(e, 1).forward);
  }
}

TEST(EdgeTable, OfNothingIsEmpty) { EXPECT_EQ(EdgeTable({}).count(), 0u); }

}  // namespace
}  // namespace slicemorph

#include "engine/volume/agree_on_winding.h"

#include "engine/numerics/edge_table.h"

#include <gtest/gtest.h>

#include <random>

namespace slicemorph {
namespace {

using openvdb::Vec3I;

/// A strip of squares around a ring, two triangles each. `twisted`: glued with a half turn (Moebius strip).
std::vector<Vec3I> ring(unsigned squares, bool twisted) {
  std::vector<Vec3I> triangles;
  for (unsigned i = 0; i < squares; ++i) {
    unsigned a = 2 * i, b = 2 * i + 1, c = 2 * (i + 1), d = 2 * (i + 1) + 1;
    if (i + 1 == squares) c = twisted ? 1 : 0, d = twisted ? 0 : 1;
    triangles.emplace_back(a, c, b);
    triangles.emplace_back(b, c, d);
  }
  return triangles;
}

/// Number of edges whose two triangles run in the same direction.
size_t disagreements(const std::vector<Vec3I>& triangles) {
  const EdgeTable edges(triangles);
  size_t count = 0;
  for (size_t e = 0; e < edges.count(); ++e)
    count += edges.faces(e) == 2 && edges.half(e, 0).forward == edges.half(e, 1).forward;
  return count;
}

TEST(AgreeOnWinding, TheMinorityIsTurned) {
  std::mt19937 random(4);
  const std::vector<Vec3I> right = ring(20, false);
  ASSERT_EQ(disagreements(right), 0u);
  for (size_t wrong : {0u, 1u, 7u, 19u}) {
    std::vector<Vec3I> given = right;
    std::vector<size_t> order(given.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), random);
    for (size_t i = 0; i < wrong; ++i) std::swap(given[order[i]][1], given[order[i]][2]);
    const AgreedWinding found = agreeOnWinding(given);
    EXPECT_EQ(found.turned, wrong);
    EXPECT_EQ(found.triangles, right);
    EXPECT_EQ(found.shells, 1u);
    EXPECT_EQ(found.twisted, 0u);
    EXPECT_EQ(found.nonManifold, 0u);
  }
}

TEST(AgreeOnWinding, PatchesAreForThemselves) {
  std::vector<Vec3I> two = ring(6, false);
  for (const Vec3I& t : ring(8, false)) two.emplace_back(t[0] + 100, t[2] + 100, t[1] + 100);
  const AgreedWinding found = agreeOnWinding(two);
  EXPECT_EQ(found.triangles, two);  // opposite windings, but each agrees with itself
  EXPECT_EQ(found.shells, 2u);
  for (size_t t = 0; t < two.size(); ++t) EXPECT_EQ(found.patch[t], t < 12 ? 0u : 12u);
}

TEST(AgreeOnWinding, NoWindingAgreesOnAMoebiusStrip) {
  const AgreedWinding found = agreeOnWinding(ring(20, true));
  EXPECT_EQ(found.twisted, 1u);
  EXPECT_EQ(disagreements(found.triangles), 1u);
}

TEST(AgreeOnWinding, EdgesOfThreeFacesPartPatchesButNotShells) {
  // Three half planes at one edge, like the leaves of a book.
  const AgreedWinding found = agreeOnWinding({{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
  EXPECT_EQ(found.nonManifold, 1u);
  EXPECT_EQ(found.shells, 1u);
  EXPECT_EQ(found.patch, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(found.turned, 0u);
}

}  // namespace
}  // namespace slicemorph

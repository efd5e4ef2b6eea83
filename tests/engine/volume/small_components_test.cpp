// Components of the inside compared with a flood fill voxel by voxel.
#include "engine/volume/small_components.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace slicemorph {
namespace {

constexpr double kComponentVoxel = 0.1;
constexpr int kReach = 36;

/// Voxels of every face-connected component within a box that encloses them all.
std::vector<std::set<openvdb::Coord>> partsOf(const FloatGrid& grid) {
  std::set<openvdb::Coord> left;
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-kReach), openvdb::Coord(kReach)).begin(); c; ++c)
    if (grid.tree().getValue(*c) < 0) left.insert(*c);
  std::vector<std::set<openvdb::Coord>> parts;
  while (!left.empty()) {
    parts.emplace_back();
    std::vector<openvdb::Coord> front{*left.begin()};
    left.erase(left.begin());
    while (!front.empty()) {
      const openvdb::Coord c = front.back();
      front.pop_back();
      parts.back().insert(c);
      for (int a = 0; a < 3; ++a)
        for (int side : {-1, 1}) {
          openvdb::Coord n = c;
          n[a] += side;
          if (left.erase(n)) front.push_back(n);
        }
    }
  }
  return parts;
}

FloatGrid::Ptr balls(const std::vector<std::pair<Vec3d, double>>& list) {
  std::vector<shapes::Distance> parts;
  for (const auto& [middle, radius] : list) parts.push_back(shapes::sphere(middle, radius));
  return shapes::levelSet(shapes::joined(parts), shapes::cube({0, 0, 0}, 0.1 * kReach), kComponentVoxel);
}

TEST(SmallComponents, PiecesAreThoseOfFloodFill) {
  std::mt19937 random(3);
  std::uniform_real_distribution<> position(-2.2, 2.2), size(0.3, 0.9);
  for (int repeat = 0; repeat < 8; ++repeat) {
    std::vector<std::pair<Vec3d, double>> list;
    for (int n = 0; n < 12; ++n)
      list.push_back({{position(random), position(random), position(random)}, size(random)});
    const FloatGrid::Ptr grid = balls(list);
    EXPECT_EQ(countPieces(*grid), int(partsOf(*grid).size())) << repeat;
  }
}

/// Inside tiles, which are no leaves, connect what touches them.
TEST(SmallComponents, LargePartsHaveTiles) {
  const FloatGrid::Ptr grid = balls({{{-1.2, 0, 0}, 1.9}, {{2.6, 0, 0}, 0.5}});
  ASSERT_LT(grid->tree().getValue({-12, 0, 0}), 0);
  ASSERT_EQ(grid->tree().probeConstLeaf({-12, 0, 0}), nullptr);
  EXPECT_EQ(countPieces(*grid), 2);
}

/// Components that touch along an edge or at a corner only are not connected.
TEST(SmallComponents, PartsAreConnectedOverFacesAlone) {
  for (const openvdb::Coord& step :
       {openvdb::Coord(4, 4, 0), openvdb::Coord(4, 4, 4), openvdb::Coord(4, 0, 0)}) {
    FloatGrid::Ptr grid = FloatGrid::create(1.f);
    for (const openvdb::Coord& first : {openvdb::Coord(5, 5, 5), openvdb::Coord(5, 5, 5) + step})
      for (auto c = openvdb::CoordBBox(first, first.offsetBy(3)).begin(); c; ++c)
        grid->tree().setValue(*c, -1.f);
    EXPECT_EQ(countPieces(*grid), step[1] == 0 ? 1 : 2) << step;
  }
}

/// Components below 27 voxels and 0.1 % of all are not counted; an empty inside still counts as one piece.
TEST(SmallComponents, DustIsNoPiece) {
  FloatGrid::Ptr grid = balls({{{0, 0, 0}, 2}});
  grid->tree().setValue({30, 30, 30}, -0.05f);
  EXPECT_EQ(countPieces(*grid), 1);
  EXPECT_EQ(countPieces(*FloatGrid::create(1.f)), 1);
}

/// The smallest are removed first, until as many are left as are allowed. The others keep every value, and
/// nothing remains of the narrow band around removed ones.
TEST(SmallComponents, TheSmallestAreRemoved) {
  const std::vector<std::pair<Vec3d, double>> list{
      {{0, 0, 0}, 2}, {{2.9, 0, 0}, 0.25}, {{0, 2.9, 0}, 0.35}, {{0, 0, -2.9}, 0.3}};
  for (int allowed = 1; allowed <= 4; ++allowed) {
    FloatGrid::Ptr grid = balls(list);
    EXPECT_EQ(removeSmallComponents(*grid, looseComponents(*grid, allowed)), 4 - allowed);
    const auto parts = partsOf(*grid);
    ASSERT_EQ(int(parts.size()), allowed);
    const double kept[4] = {2, 0.35, 0.3, 0.25};
    std::vector<std::pair<Vec3d, double>> rest;
    for (int n = 0; n < allowed; ++n)
      for (const auto& ball : list)
        if (ball.second == kept[n]) rest.push_back(ball);
    const FloatGrid::Ptr wanted = balls(rest);
    for (auto it = wanted->cbeginValueOn(); it; ++it)
      if (*it < 0) {
        ASSERT_EQ(grid->tree().getValue(it.getCoord()), *it) << it.getCoord();
      }
    for (auto it = grid->cbeginValueOn(); it; ++it) {
      // No active voxel is further from the remaining inside than the band reaches.
      double nearest = 1e30;
      for (const auto& [middle, radius] : rest)
        nearest = std::min(nearest, (grid->indexToWorld(it.getCoord()) - middle).length() - radius);
      ASSERT_LT(nearest, (kHalfWidth + 4) * kComponentVoxel) << it.getCoord();
    }
  }
}

/// Large components are kept, however few are allowed.
TEST(SmallComponents, LargePartsStay) {
  FloatGrid::Ptr grid = balls({{{-1, 0, 0}, 0.9}, {{1, 0, 0}, 0.7}});
  const FloatGrid::Ptr before = grid->deepCopy();
  EXPECT_EQ(removeSmallComponents(*grid, looseComponents(*grid, 1)), 0);
  EXPECT_TRUE(sameValues(*grid, *before));
}

/// A void of one voxel is filled, wherever it lies in a leaf; one of two voxels is a void, and so is a dent.
TEST(SmallComponents, VoidsOfOneVoxelAreFilled) {
  FloatGrid::Ptr grid = balls({{{0, 0, 0}, 2}});
  const FloatGrid::Ptr whole = grid->deepCopy();
  const float h = float(grid->voxelSize()[0]);
  const openvdb::Coord inside(2, 3, 4), atBorder(8, 0, 7), pair(-3, -3, -3), other(-3, -3, -2);
  for (const openvdb::Coord& c : {inside, atBorder, pair, other}) {
    ASSERT_LT(whole->tree().getValue(c), -1.5f * h);  // with neighbours within
    grid->tree().setValueOn(c, 0.25f * h);
  }
  EXPECT_EQ(fillVoxelVoids(*grid), 2);
  for (const openvdb::Coord& c : {inside, atBorder}) EXPECT_LT(grid->tree().getValue(c), 0);
  for (const openvdb::Coord& c : {pair, other}) EXPECT_EQ(grid->tree().getValue(c), 0.25f * h);
  EXPECT_EQ(fillVoxelVoids(*grid), 0);
  FloatGrid::Ptr untouched = whole->deepCopy();
  EXPECT_EQ(fillVoxelVoids(*untouched), 0);
  EXPECT_TRUE(sameValues(*untouched, *whole));
}

}  // namespace
}  // namespace slicemorph

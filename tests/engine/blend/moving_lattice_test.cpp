// The moving lattice: at the objects' weights it is the objects', between them nodes move on straight paths,
// and interpolation in it is exact for affine maps.
#include "engine/blend/moving_lattice.h"

#include "engine/blend/box_nodes.h"
#include "tests/support/fields.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

using Transform = openvdb::math::Transform;

constexpr double kVoxel = 0.05;

/// Two balls that are equal in the middle space but for a smooth displacement, with charts of different
/// positions, rotations and scales.
struct Pair {
  Fields fields;
  std::vector<Chart> charts;
  Displacements map;
};

Pair ballsApart(double wave) {
  Pair pair;
  pair.charts = {shapes::straightChart({0, 0, 0}, 1), shapes::straightChart({4, 1, 0}, 1.5)};
  pair.charts[1].axes = rotationFromVector({0, 0, 0.6});
  pair.fields = {shapes::fieldOf(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1.2), kVoxel),
                 shapes::fieldOf(shapes::sphere({4, 1, 0}, 1.5), shapes::cube({4, 1, 0}, 1.8), 1.5 * kVoxel)};
  pair.map.lattice = Lattice::over({Vec3d(-1.5), Vec3d(1.5)}, 0.1);
  pair.map.of.assign(2, VectorField(pair.map.lattice.count()));
  for (int z = 0; z < pair.map.lattice.size[2]; ++z)
    for (int y = 0; y < pair.map.lattice.size[1]; ++y)
      for (int x = 0; x < pair.map.lattice.size[0]; ++x) {
        const Vec3d s = pair.map.lattice.position(x, y, z);
        const openvdb::Vec3s d(Vec3d(wave * std::sin(s[1]), 0, wave * std::cos(2 * s[0])));
        pair.map.of[0][pair.map.lattice.index(x, y, z)] = d;
        pair.map.of[1][pair.map.lattice.index(x, y, z)] = -d;
      }
  return pair;
}

Transform::Ptr voxels(double h) { return Transform::createLinearTransform(h); }

Vec3d nodeOf(const Pair& pair, size_t i) {
  const openvdb::Coord n = pair.map.lattice.size;
  return pair.map.lattice.position(int(i % n[0]), int(i / n[0] % n[1]), int(i / (size_t(n[0]) * n[1])));
}

TEST(MovingLattice, AtAnObjectItIsTheObjects) {
  const Pair pair = ballsApart(0.1);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  for (size_t k = 0; k < 2; ++k) {
    Weights w(2, 0);
    w[k] = 1;
    const MovingLattice::Pose blended = lattice.poseAt(w), own = lattice.poseOf(k);
    for (size_t i = 0; i < own.world.size(); ++i) {
      const Vec3d wanted = pair.charts[k].toWorld(nodeOf(pair, i) + Vec3d(pair.map.of[k][i]));
      ASSERT_LE((own.world[i] - wanted).length(), 1e-6);
      ASSERT_LE((blended.world[i] - wanted).length(), 1e-6);
    }
    EXPECT_EQ(own.straightening, 0);
  }
}

/// Where the displacements sum to zero, paths in chart space are straight; scales and positions are linear,
/// and the rotation angle is proportional to the weight.
TEST(MovingLattice, BetweenObjectsPointsGoStraightOn) {
  const Pair pair = ballsApart(0.1);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  for (double t : {-0.1, 0.3, 0.5, 0.8}) {
    const MovingLattice::Pose pose = lattice.poseAt({1 - t, t});
    const Mat3d turn = rotationFromVector({0, 0, 0.6 * t});
    for (size_t i = 0; i < pose.world.size(); ++i) {
      const Vec3d s = nodeOf(pair, i) + (1 - 2 * t) * Vec3d(pair.map.of[0][i]);
      const Vec3d wanted = t * Vec3d(4, 1, 0) + (1 + 0.5 * t) * (turn * s);
      ASSERT_LE((pose.world[i] - wanted).length(), 1e-5) << t;
    }
  }
}

/// Without displacements the map from an in-between to an object is a similarity.
Vec3d placeOn(size_t object, double t, const Vec3d& p) {
  const Vec3d s = rotationFromVector({0, 0, -0.6 * t}) * (p - t * Vec3d(4, 1, 0)) / (1 + 0.5 * t);
  return object == 0 ? s : Vec3d(4, 1, 0) + 1.5 * (rotationFromVector({0, 0, 0.6}) * s);
}

/// Nodes inside the lattice are mapped by its tetrahedra, those beyond it by the charts.
TEST(MovingLattice, NodesOfABoxLieWhereTheMapLeads) {
  const Pair pair = ballsApart(0);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  const double t = 0.4;
  const openvdb::CoordBBox box({-20, -15, -30}, {70, 40, 30});
  const Transform::Ptr transform = voxels(0.07);
  for (int step : {2, 4}) {
    const NodeMap nodes = lattice.nodesWithin(box, lattice.poseAt({1 - t, t}), *transform, step);
    ASSERT_EQ(nodes.objects, 2u);
    for (int a = 0; a < 3; ++a) {
      EXPECT_LE(step * (nodes.origin[a] + 1), box.min()[a]);
      EXPECT_GE(step * (nodes.origin[a] + nodes.size[a] - 2), box.max()[a]);
    }
    for (int k = nodes.origin[2]; k < nodes.origin[2] + nodes.size[2]; ++k)
      for (int j = nodes.origin[1]; j < nodes.origin[1] + nodes.size[1]; ++j)
        for (int i = nodes.origin[0]; i < nodes.origin[0] + nodes.size[0]; ++i) {
          const size_t n = nodes.index(i, j, k);
          ASSERT_TRUE(nodes.known[n]);
          const Vec3d p = transform->indexToWorld(step * Vec3d(i, j, k));
          for (size_t object = 0; object < 2; ++object)
            ASSERT_LE(
                (Vec3d(nodes.at[2 * n + object]) + pair.fields[object]->anchor() - placeOn(object, t, p))
                    .length(),
                1e-5);
        }
  }
}

/// The map and its inverse agree: a node carried to an object and back through the lattice to the
/// in-between returns to itself.
TEST(MovingLattice, NodesAreFoundBackThroughTheMap) {
  const Pair pair = ballsApart(0.12);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  const double t = 0.35;
  const MovingLattice::Pose pose = lattice.poseAt({1 - t, t});
  const Transform::Ptr transform = voxels(0.06);
  const NodeMap nodes = lattice.nodesNearSurface(pose, *transform, 4);
  std::vector<Vec3d> onObject, here;
  for (int k = nodes.origin[2]; k < nodes.origin[2] + nodes.size[2]; ++k)
    for (int j = nodes.origin[1]; j < nodes.origin[1] + nodes.size[1]; ++j)
      for (int i = nodes.origin[0]; i < nodes.origin[0] + nodes.size[0]; ++i) {
        const size_t n = nodes.index(i, j, k);
        if (!nodes.known[n] || (i + j + k) % 7) continue;
        here.push_back(transform->indexToWorld(4.0 * Vec3d(i, j, k)));
        onObject.push_back(Vec3d(nodes.at[2 * n + 1]) + pair.fields[1]->anchor());
      }
  ASSERT_GT(here.size(), 100u);
  const std::vector<Vec3d> back = lattice.carryPoints(onObject, lattice.poseOf(1), pose);
  for (size_t i = 0; i < here.size(); ++i)
    // Points are carried by the trilinear field, nodes by tetrahedra: they differ by up to an eighth of the
    // second differences, 0.12 * 4 * 0.1^2, and by what the first differences make of that.
    EXPECT_LE((back[i] - here[i]).length(), 0.002 * 1.5) << here[i];
}

/// All nodes within the band around the in-between's surface are known, and no fold is counted.
TEST(MovingLattice, NodesCoverTheBand) {
  const Pair pair = ballsApart(0);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  const double t = 0.5, h = 0.06;
  const Transform::Ptr transform = voxels(h);
  const NodeMap nodes = lattice.nodesNearSurface(lattice.poseAt({1 - t, t}), *transform, 4);
  EXPECT_EQ(nodes.foldShare, 0);
  size_t seen = 0;
  for (int k = -60; k < 60; ++k)
    for (int j = -60; j < 60; ++j)
      for (int i = -60; i < 60; ++i) {
        const Vec3d p = transform->indexToWorld(4.0 * Vec3d(i, j, k));
        if (std::abs((p - Vec3d(2, 0.5, 0)).length() - 1.25) > (kHalfWidth + 4 * std::sqrt(3.0)) * h)
          continue;
        ++seen;
        ASSERT_TRUE(nodes.inside(i, j, k)) << p;
        ASSERT_TRUE(nodes.known[nodes.index(i, j, k)]) << p;
      }
  EXPECT_GT(seen, 100u);
}

/// A map that turns space inside out near the surface is counted as folded.
TEST(MovingLattice, FoldsAreCounted) {
  Pair pair = ballsApart(0);
  for (size_t i = 0; i < pair.map.lattice.count(); ++i) {
    const Vec3d s = nodeOf(pair, i);
    if (s[0] < 0) continue;
    pair.map.of[0][i] = openvdb::Vec3s(float(-1.5 * s[0]), 0, 0);
    pair.map.of[1][i] = -pair.map.of[0][i];
  }
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  EXPECT_GT(lattice.nodesNearSurface(lattice.poseAt({0.5, 0.5}), *voxels(0.06), 4).foldShare, 0.1);
}

std::vector<char> allNodes(const NodeMap& map) {
  return std::vector<char>(size_t(map.size[0]) * map.size[1] * map.size[2], 1);
}

/// The velocity at a position while t grows by one per unit of time: d/dt of position(t) for a
/// rigid motion with growth.
TEST(MovingLattice, VelocitiesAreTheMotions) {
  const Pair pair = ballsApart(0);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  const double t = 0.4;
  const Transform::Ptr transform = voxels(0.1);
  const openvdb::CoordBBox box({-10, -10, -10}, {40, 20, 10});
  const MovingLattice::Pose pose = lattice.poseAt({1 - t, t});
  const NodeMap empty = emptyNodes(box, 4);
  const LatticeMotion motion = lattice.motionAt({1 - t, t}, {-2, 2}, pose);
  const NodeMap nodes = lattice.velocityFinder(motion, pose, *transform, 4).find(empty, allNodes(empty));
  const auto at = [&](double time, const Vec3d& s) {
    return time * Vec3d(4, 1, 0) + (1 + 0.5 * time) * (rotationFromVector({0, 0, 0.6 * time}) * s);
  };
  for (int k = nodes.origin[2]; k < nodes.origin[2] + nodes.size[2]; ++k)
    for (int j = nodes.origin[1]; j < nodes.origin[1] + nodes.size[1]; ++j)
      for (int i = nodes.origin[0]; i < nodes.origin[0] + nodes.size[0]; ++i) {
        const Vec3d p = transform->indexToWorld(4.0 * Vec3d(i, j, k)), s = placeOn(0, t, p);
        constexpr double kStep = 1e-4;
        const Vec3d wanted = 2.0 * (at(t + kStep, s) - at(t - kStep, s)) / (2 * kStep);
        ASSERT_LE((Vec3d(nodes.at[nodes.index(i, j, k)]) - wanted).length(), 1e-4 * (1 + wanted.length()))
            << p;
      }
}

/// Some nodes have the values that they have among all, and the others none.
TEST(MovingLattice, SomeNodesAreAsAllAre) {
  const Pair pair = ballsApart(0.1);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  const MovingLattice::Pose pose = lattice.poseAt({0.5, 0.5});
  const LatticeMotion motion = lattice.motionAt({0.5, 0.5}, {-1, 1}, pose);
  const NodeMap empty = emptyNodes({{-10, -10, -10}, {40, 20, 10}}, 4);
  std::vector<char> some = allNodes(empty);
  for (size_t n = 0; n < some.size(); ++n) some[n] = n % 7 == 0;
  const Transform::Ptr transform = voxels(0.1);
  VelocityFinder finder = lattice.velocityFinder(motion, pose, *transform, 4);
  const NodeMap whole = finder.find(empty, allNodes(empty)), part = finder.find(empty, some);
  for (size_t n = 0; n < some.size(); ++n) {
    EXPECT_EQ(bool(part.known[n]), bool(some[n]));
    EXPECT_TRUE(whole.known[n]);
    if (some[n]) {
      EXPECT_EQ(part.at[n], whole.at[n]);
    }
  }
  // Where nodes lie may be known from another map of the in-between.
  const NodeMap surface = lattice.nodesNearSurface(pose, *transform, 4);
  VelocityFinder knowing = lattice.velocityFinder(motion, pose, *transform, 4);
  knowing.knows(surface);
  EXPECT_EQ(knowing.find(empty, allNodes(empty)).at, whole.at);
}

/// Rates of zero give velocities of zero.
TEST(MovingLattice, WhatDoesNotChangeHasNoVelocity) {
  const Pair pair = ballsApart(0.1);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  const MovingLattice::Pose pose = lattice.poseAt({0.5, 0.5});
  const NodeMap empty = emptyNodes({{-5, -5, -5}, {5, 5, 5}}, 4);
  const LatticeMotion motion = lattice.motionAt({0.5, 0.5}, {0, 0}, pose);
  const Transform::Ptr transform = voxels(0.1);
  const NodeMap nodes = lattice.velocityFinder(motion, pose, *transform, 4).find(empty, allNodes(empty));
  for (const openvdb::Vec3s& v : nodes.at) EXPECT_EQ(v, openvdb::Vec3s(0.f));
}

TEST(MovingLattice, BoxesHoldWhatIsCarriedIntoThem) {
  const Pair pair = ballsApart(0.1);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  const MovingLattice::Pose pose = lattice.poseAt({0.3, 0.7});
  const Transform::Ptr transform = voxels(0.06);
  const openvdb::BBoxd part(Vec3d(0.1, -0.3, -0.9), Vec3d(0.9, 0.5, 0.2));
  const openvdb::BBoxd box = lattice.boxOf(0, part, pose, *transform);
  std::mt19937 random(5);
  std::vector<Vec3d> points;
  for (int i = 0; i < 300; ++i) {
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = std::uniform_real_distribution<>(part.min()[a], part.max()[a])(random);
    points.push_back(p);
  }
  for (const Vec3d& p : lattice.carryPoints(points, lattice.poseOf(0), pose))
    EXPECT_TRUE(box.isInside(transform->worldToIndex(p))) << p;
  // And not much more: its sides are those of the part, wider by a few cells and by the rotation.
  EXPECT_LT(box.extents().length() * 0.06, 2.5 * part.extents().length());
}

/// A region with all weight on the other object gives that part the other's size; the rest keeps its own.
TEST(MovingLattice, RegionsHaveTheirOwnSize) {
  Pair pair = ballsApart(0);
  pair.charts[1] = shapes::straightChart({0, 0, 0}, 1.5);
  pair.fields[1] =
      shapes::fieldOf(shapes::sphere({0, 0, 0}, 1.5), shapes::cube({0, 0, 0}, 1.8), 1.5 * kVoxel);
  Region half;
  half.kind = Region::Kind::kSpine, half.object = 0, half.from = 0.5, half.border = 0.3,
  half.weights = {0, 1};
  const auto regions =
      std::make_shared<RegionShares>(std::vector<Region>{half}, pair.fields, pair.charts, pair.charts);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts, regions);
  const MovingLattice::Pose pose = lattice.poseAt({1, 0});
  double left = 0, right = 0;
  for (size_t i = 0; i < pose.world.size(); ++i) {
    const Vec3d s = nodeOf(pair, i);
    if (std::hypot(s[1], s[2]) > 1e-9 && std::abs(std::hypot(s[1], s[2]) - 0.5) < 0.01) {
      const double r = std::hypot(pose.world[i][1], pose.world[i][2]) / std::hypot(s[1], s[2]);
      if (s[0] < -0.5) {
        EXPECT_NEAR(r, 1, 1e-3);
        ++left;
      }
      if (s[0] > 0.5) {
        EXPECT_NEAR(r, 1.5, 1e-3);
        ++right;
      }
    }
  }
  EXPECT_GT(left, 0);
  EXPECT_GT(right, 0);
  // The pose of the object itself ignores regions.
  EXPECT_LE((lattice.poseOf(0).world[3] - nodeOf(pair, 3)).length(), 1e-6);
}

TEST(MovingLattice, IsTheSameForAnyNumberOfThreads) {
  const Pair pair = ballsApart(0.1);
  const MovingLattice lattice(pair.map, pair.fields, pair.charts);
  const auto made = [&](size_t threads) {
    return withThreads(threads, [&] {
      return lattice.nodesNearSurface(lattice.poseAt({0.3, 0.7}), *voxels(0.06), 4);
    });
  };
  const NodeMap one = made(1), four = made(4);
  EXPECT_EQ(one.at, four.at);
  EXPECT_EQ(one.known, four.known);
}

}  // namespace
}  // namespace slicemorph

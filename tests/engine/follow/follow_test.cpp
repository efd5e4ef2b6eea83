// Meshes that keep their triangles over a morph's frames: points move to where a closed form has them, and
// onto surfaces.
#include "engine/follow/moving_mesh.h"
#include "engine/follow/onto_surface.h"
#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"
#include "tests/support/shapes.h"
#include "tests/support/surface_checks.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <random>

namespace slicemorph {
namespace {

constexpr double kVoxel = 2.0 / 48;

Object object(const FloatGrid::Ptr& grid) { return {"shape", grid}; }

FloatGrid::Ptr ball(const Vec3d& centre, double radius) {
  return shapes::levelSet(shapes::sphere(centre, radius), shapes::cube(centre, radius + 0.5), kVoxel);
}

std::vector<Vec3d> pointsOf(const Mesh& mesh) { return {mesh.points.begin(), mesh.points.end()}; }

std::vector<SurfaceFrame> framesOf(const MorphPlan& plan, int count) {
  std::vector<SurfaceFrame> frames;
  for (int i = 0; i < count; ++i) {
    const Weights w{1 - double(i) / (count - 1), double(i) / (count - 1)};
    frames.push_back({plan.frame(w).surface, w});
  }
  return frames;
}

TEST(CarryPoints, ABallThatMovesAndGrowsTakesItsPointsStraightAlong) {
  const Vec3d a(0, 0, 0), b(3, 1, -2);
  const MorphPlan plan({object(ball(a, 1)), object(ball(b, 2))});
  const std::vector<Vec3d> start = pointsOf(surfaceOf(*ball(a, 1)));
  for (const double t : {0.2, 0.5, 1.0}) {
    const std::vector<Vec3d> there = plan.carryPoints(start, {1, 0}, {1 - t, t});
    double most = 0;
    for (size_t i = 0; i < start.size(); ++i)
      most = std::max(most, (there[i] - (start[i] * (1 + t) + t * b)).length());
    // The map is matched, not prescribed: half a voxel of the larger ball.
    EXPECT_LT(most, 0.5 * kVoxel * 2) << t;
    const std::vector<Vec3d> back = plan.carryPoints(there, {1 - t, t}, {1, 0});
    most = 0;
    for (size_t i = 0; i < start.size(); ++i) most = std::max(most, (back[i] - start[i]).length());
    // The inverse is found to a thousandth of the lattice's spacing, which is below ten voxels.
    EXPECT_LT(most, 0.01 * kVoxel) << t;
  }
}

TEST(CarryPoints, ABarThatTurnsCarriesItsEndsAlongTheArc) {
  const shapes::Distance bar = shapes::box({1, 0.25, 0.15}, 0.1);
  const double angle = 1;
  // OpenVDB's matrices are for row vectors
  const Mat3d turn = openvdb::math::rotation<Mat3d>(Vec3d(0, 0, 1), -angle);
  const MorphPlan plan(
      {object(shapes::levelSet(bar, shapes::cube({0, 0, 0}, 1.3), kVoxel)),
       object(shapes::levelSet(shapes::placed(bar, turn, {0, 0, 0}), shapes::cube({0, 0, 0}, 1.3), kVoxel))});
  const std::vector<Vec3d> start{{0.95, 0.1, 0.05}, {-0.95, 0.1, 0}, {0.95, -0.15, 0}, {0.1, 0.2, 0.1}};
  const std::vector<Vec3d> end = plan.correspond(start, 0, 1),
                           there = plan.carryPoints(start, {1, 0}, {0, 1});
  for (size_t i = 0; i < start.size(); ++i) {
    EXPECT_LT((there[i] - end[i]).length(), 1e-6 * kVoxel) << i;
    const Vec3d middle = plan.carryPoints(start, {1, 0}, {0.5, 0.5})[i];
    EXPECT_NEAR(middle.length(), start[i].length(), 0.5 * kVoxel) << i;
  }
}

TEST(OntoSurface, PointsNearAndFarComeToRestOnASphere) {
  const Vec3d centre(0.3, -0.2, 5);
  const FloatGrid::Ptr grid = ball(centre, 1);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-1, 1), radius(0.5, 2);
  std::vector<Vec3d> points;
  while (points.size() < 1000) {
    Vec3d direction(coordinate(random), coordinate(random), coordinate(random));
    if (direction.length() < 0.1 || direction.length() > 1) continue;
    points.push_back(centre + radius(random) * direction.unit());
  }
  const std::vector<Vec3d> there = ontoSurface(points, *grid);
  for (size_t i = 0; i < points.size(); ++i) {
    // Trilinear interpolation of a distance loses a voxel's square over eight radii, in each direction.
    EXPECT_NEAR((there[i] - centre).length(), 1, 3 * kVoxel * kVoxel / 8 + 2e-3 * kVoxel);
    // Up to two voxels aside for points from far away, which go to the nearest surface point first.
    EXPECT_LT((there[i] - centre - (points[i] - centre).unit()).length(), 2 * kVoxel);
  }
}

TEST(MovingMesh, OneMeshForWhatKeepsItsShape) {
  const MorphPlan plan({object(ball({0, 0, 0}, 1)), object(ball({2, 0, 0}, 1.5))});
  const std::vector<SurfaceFrame> frames = framesOf(plan, 7);
  const std::vector<MovingMesh> meshes = followSurfaces(frames, &plan);
  ASSERT_EQ(meshes.size(), 1u);
  ASSERT_EQ(meshes[0].points.size(), 7u);
  EXPECT_EQ(meshes[0].first, 0u);
  for (size_t i = 0; i < 7; ++i) {
    const double t = double(i) / 6, radius = 1 + 0.5 * t;
    const Mesh mesh{meshes[0].points[i], meshes[0].triangles};
    EXPECT_EQ(checks::closedAndManifold(mesh), "");
    for (const openvdb::Vec3s& p : mesh.points)
      EXPECT_NEAR((Vec3d(p) - Vec3d(2 * t, 0, 0)).length(), radius, 0.5 * kVoxel);
  }
}

TEST(MovingMesh, SeveralWhereAHoleOpensAndEachFrameInOne) {
  const FloatGrid::Ptr ring =
      shapes::levelSet(shapes::torus({0, 0, 0}, 1, 0.35), shapes::cube({0, 0, 0}, 1.6), kVoxel);
  const MorphPlan plan({object(ball({0, 0, 0}, 1)), object(ring)});
  const std::vector<SurfaceFrame> frames = framesOf(plan, 7);
  const FollowLimits limits;
  const std::vector<MovingMesh> meshes = followSurfaces(frames, &plan, limits);
  EXPECT_GT(meshes.size(), 1u);
  size_t next = 0;
  for (const MovingMesh& m : meshes) {
    ASSERT_EQ(m.first, next);
    for (size_t i = 0; i < m.points.size(); ++i) {
      const FloatGrid& surface = *frames[m.first + i].surface;
      const Mesh mesh{m.points[i], m.triangles}, own = surfaceOf(surface);
      const SurfaceDistance distance = distanceTo(own.points, mesh);
      EXPECT_LE(distance.max, limits.most * surface.voxelSize()[0]);
      EXPECT_LE(distance.p99, limits.p99 * surface.voxelSize()[0]);
      EXPECT_NEAR(measureMesh(mesh).volume, measureMesh(own).volume,
                  limits.mean * surface.voxelSize()[0] * measureMesh(own).area);
    }
    next += m.points.size();
  }
  EXPECT_EQ(next, frames.size());
}

TEST(MovingMesh, TheSameForAnyThreadCount) {
  const MorphPlan plan({object(ball({0, 0, 0}, 1)), object(ball({2, 0, 0}, 1.5))});
  const std::vector<SurfaceFrame> frames = framesOf(plan, 3);
  std::vector<std::string> bytes;
  for (const int threads : {1, 2, 4})
    withThreads(size_t(threads), [&] {
      bytes.emplace_back();
      for (const MovingMesh& m : followSurfaces(frames, &plan))
        for (const auto& points : m.points) bytes.back() += checks::bytesOf(points);
    });
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_EQ(bytes[0], bytes[2]);
}

TEST(MovingMesh, AFrameWithNothingHasAMeshWithNothing) {
  const MorphPlan plan({object(ball({0, 0, 0}, 1)), object(ball({2, 0, 0}, 1.5))});
  std::vector<SurfaceFrame> frames = framesOf(plan, 5);
  for (const size_t empty : {1u, 2u}) frames[empty].surface = openvdb::createLevelSet<FloatGrid>(kVoxel, 3);
  const std::vector<MovingMesh> meshes = followSurfaces(frames, &plan);
  size_t next = 0;
  for (const MovingMesh& m : meshes) {
    ASSERT_EQ(m.first, next);
    for (size_t i = 0; i < m.points.size(); ++i)
      EXPECT_EQ(m.triangles.empty(), next + i == 1 || next + i == 2) << next + i;
    next += m.points.size();
  }
  EXPECT_EQ(next, frames.size());
}

TEST(OntoSurface, ATriangleThatIsTurnedOverFacesInwards) {
  const FloatGrid::Ptr grid = ball({0, 0, 0}, 1);
  Mesh mesh = surfaceOf(*grid);
  EXPECT_EQ(shareFacingInwards(mesh, *grid), 0);
  for (size_t i = 0; i < mesh.triangles.size(); i += 2) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  EXPECT_NEAR(shareFacingInwards(mesh, *grid), 0.5, 0.02);
}

TEST(MovingMesh, WithoutAPlanEachFrameHasItsOwn) {
  const std::vector<SurfaceFrame> frames{{ball({0, 0, 0}, 1), {1, 0}}, {ball({0, 0, 0}, 1.1), {0, 1}}};
  const std::vector<MovingMesh> meshes = followSurfaces(frames, nullptr);
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[1].first, 1u);
  EXPECT_EQ(meshes[1].points.size(), 1u);
}

}  // namespace
}  // namespace slicemorph

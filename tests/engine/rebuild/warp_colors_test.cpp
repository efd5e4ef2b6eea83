// Colours carried with the surface, at 128 voxels along the longest side.
#include "engine/volume/surface_colors.h"
#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;
using Color = std::function<Vec3s(const Vec3d&)>;

Vec3SGrid::Ptr painted(const FloatGrid& levelSet, const Color& color) {
  auto grid = Vec3SGrid::create(Vec3s(0.f));
  grid->setTransform(levelSet.transform().copy());
  auto accessor = grid->getAccessor();
  for (auto v = levelSet.cbeginValueOn(); v; ++v)
    accessor.setValue(v.getCoord(), color(levelSet.indexToWorld(v.getCoord())));
  return grid;
}

/// Along an axis in the plane z = 0, thin at its start and thick at its end.
shapes::Distance tapered(double angle) {
  const Vec3d axis(std::cos(angle), std::sin(angle), 0);
  return [=](const Vec3d& p) {
    const double along = p.dot(axis), radius = 0.35 + 0.1 * along;
    const double r = (p - along * axis).length() - radius, x = std::abs(along) - 1.5;
    return 0.99 * (std::hypot(std::max(r, 0.0), std::max(x, 0.0)) + std::min(std::max(r, x), 0.0));
  };
}

constexpr double kVoxel = 3.0 / 128;
const openvdb::BBoxd kBox = shapes::cube({0, 0, 0}, 1.8);

/// The thick half is red, the thin half blue; turned by 90 degrees. At every time the border of the colours
/// is the turned border.
TEST(Colors, BorderTurnsWithTheBar) {
  std::vector<Object> objects;
  std::vector<Vec3SGrid::ConstPtr> colors;
  for (double angle : {0.0, kPi / 2}) {
    objects.push_back({"bar", shapes::levelSet(tapered(angle), kBox, kVoxel)});
    const Vec3d axis(std::cos(angle), std::sin(angle), 0);
    colors.push_back(painted(*objects.back().levelSet, [=](const Vec3d& p) {
      return p.dot(axis) > 0 ? Vec3s(1, 0, 0) : Vec3s(0, 0, 1);
    }));
  }
  const MorphPlan plan(objects);
  for (int i = 0; i <= 8; ++i) {
    const double t = i / 8.0, angle = t * kPi / 2;
    const FloatGrid::Ptr surface = plan.frame({1 - t, t}).surface;
    const Vec3SGrid::Ptr cd = plan.pullback({1 - t, t}).colors(*surface, colors);
    const Vec3d axis(std::cos(angle), std::sin(angle), 0);
    double off = 0, mixed = 0;
    size_t count = 0;
    for (auto v = cd->cbeginValueOn(); v; ++v, ++count) {
      const double along = cd->indexToWorld(v.getCoord()).dot(axis);
      EXPECT_NEAR((*v)[0] + (*v)[2], 1, 1e-5);
      EXPECT_EQ((*v)[1], 0);
      if (((*v)[0] > 0.5f) != (along > 0)) off = std::max(off, std::abs(along));
      if ((*v)[0] > 0.02f && (*v)[0] < 0.98f) mixed = std::max(mixed, std::abs(along));
    }
    std::printf("  t %.3f: border off by %.2f voxels, mixed up to %.2f\n", t, off / kVoxel, mixed / kVoxel);
    EXPECT_LE(off / kVoxel, 1) << "t " << t;
    EXPECT_LE(mixed / kVoxel, 2) << "t " << t;
    EXPECT_EQ(count, surface->activeVoxelCount());
  }
}

TEST(Colors, GreysBlendByTheirWeights) {
  const double voxel = 2 * kVoxel;  // values, not shapes, are looked at
  const Object a{"ball", shapes::levelSet(shapes::sphere({0, 0, 0}, 1), kBox, voxel)};
  const Object b{"box", shapes::levelSet(shapes::box({1.2, 0.5, 0.7}, 0.1), kBox, voxel)};
  const Object c{"cube", shapes::levelSet(shapes::box({0.8, 0.8, 0.8}, 0.1), kBox, voxel)};
  const std::vector<Vec3SGrid::ConstPtr> colors{
      painted(*a.levelSet, [](const Vec3d&) { return Vec3s(0.2f); }),
      painted(*b.levelSet, [](const Vec3d&) { return Vec3s(0.8f); }), nullptr};
  const MorphPlan plan({a, b, c});
  const auto check = [&](const Weights& w, float wanted) {
    const FloatGrid::Ptr surface = plan.frame(w).surface;
    const Vec3SGrid::Ptr cd = plan.pullback(w).colors(*surface, colors);
    for (auto v = cd->cbeginValueOn(); v; ++v)
      for (int i = 0; i < 3; ++i)
        ASSERT_NEAR((*v)[i], wanted, 1e-5) << "weights " << w[0] << " " << w[1] << " " << w[2];
    EXPECT_EQ(cd->activeVoxelCount(), surface->activeVoxelCount());
  };
  check({0.25, 0.75, 0}, 0.65f);
  check({0.3, 0.3, 0.4}, 0.5f);  // an object without colours contributes none
  check({1, 0, 0}, 0.2f);
  check({0, 0, 1}, 0.5f);  // and where it alone has weight, the others' are used
}

/// The colours of a grid carried with fog: inactive voxels have no colour.
TEST(Colors, FogsColoursDoNotBleed) {
  std::vector<Object> objects;
  std::vector<openvdb::GridBase::ConstPtr> colors;
  const Vec3s own[2] = {{0.9f, 0.3f, 0.1f}, {0.1f, 0.5f, 0.7f}};
  for (int k = 0; k < 2; ++k) {
    objects.push_back(
        {"o", shapes::levelSet(k ? shapes::box({1.2, 0.5, 0.7}, 0.1) : shapes::sphere({0, 0, 0}, 1), kBox,
                               2 * kVoxel)});
    const Vec3SGrid::Ptr grid = painted(*objects.back().levelSet, [&](const Vec3d&) { return own[k]; });
    grid->setName("Cd");
    colors.push_back(grid);
  }
  const auto cd = openvdb::gridConstPtrCast<Vec3SGrid>(MorphPlan(objects).pullback({0.5, 0.5}).carry(colors));
  ASSERT_GT(cd->activeVoxelCount(), 1000u);
  for (auto v = cd->cbeginValueOn(); v; ++v) {
    // On the line between the two colours, hence nowhere darker.
    const double s = ((*v)[0] - own[1][0]) / (own[0][0] - own[1][0]);
    ASSERT_GE(s, -1e-5);
    ASSERT_LE(s, 1 + 1e-5);
    for (int i = 0; i < 3; ++i) ASSERT_NEAR((*v)[i], own[1][i] + s * (own[0][i] - own[1][i]), 1e-5);
  }
}

TEST(Colors, NoneAtAllIsAnError) {
  const Object a{"ball", shapes::levelSet(shapes::sphere({0, 0, 0}, 1), kBox, 3 * kVoxel)};
  const Object b{"box", shapes::levelSet(shapes::box({1.2, 0.5, 0.7}, 0.1), kBox, 3 * kVoxel)};
  const MorphPlan plan({a, b});
  Pullback pullback = plan.pullback({0.5, 0.5});
  EXPECT_THROW(pullback.colors(*a.levelSet, {nullptr, nullptr}), InputError);
}

}  // namespace
}  // namespace slicemorph

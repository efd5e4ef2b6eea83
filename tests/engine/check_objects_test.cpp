// Inputs that a morph refuses; messages must say what would be right.
#include "engine/check_objects.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace slicemorph {
namespace {

constexpr double kVoxel = 0.1;

FloatGrid::Ptr ball(const Vec3d& centre = {0, 0, 0}) {
  return shapes::levelSet(shapes::sphere(centre, 1), shapes::cube(centre, 1), kVoxel);
}

/// The message of the E that a call throws; empty where it throws none.
template <typename E>
std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const E& e) {
    return e.what();
  }
  return "";
}

void expectSays(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
}

/// A ball that `spoil` makes invalid is refused as any input of a morph, also as an inner surface.
void expectRefused(const std::function<void(FloatGrid&)>& spoil, const std::vector<std::string>& says) {
  const FloatGrid::Ptr bad = ball();
  spoil(*bad);
  const Object good{"good", ball()};
  expectSays(refusal<GeometryError>([&] { MorphPlan({good, {"bad.vdb", bad}}); }), says);
  expectSays(refusal<GeometryError>([&] {
               MorphPlan({good, {"bad.vdb", bad}}, MorphPlan({good, good}));
             }),
             says);
  expectSays(refusal<GeometryError>([&] {
               MorphPlan({good, {"bad.vdb", ball(), {nullptr, bad}}});
             }),
             {"inner surface 2", says[1]});
}

TEST(CheckObjects, ClassMustBeLevelSet) {
  expectRefused([](FloatGrid& grid) { grid.setGridClass(openvdb::GRID_FOG_VOLUME); },
                {"'bad.vdb'", "Fog Volume", "level set"});
}

TEST(CheckObjects, VoxelsMustBeCubesAlongTheAxes) {
  expectRefused([](FloatGrid& grid) { grid.transform().preScale(Vec3d(1, 1, 2)); },
                {"'bad.vdb'", "0.1, 0.1, 0.2", "along all axes"});
  expectRefused([](FloatGrid& grid) { grid.transform().postRotate(0.5, openvdb::math::Z_AXIS); },
                {"'bad.vdb'", "x axis points along (0.87", "the world's"});
  // Equal sizes along all axes, but one axis is reversed.
  expectRefused([](FloatGrid& grid) { grid.transform().preScale(Vec3d(1, -1, 1)); },
                {"'bad.vdb'", "y axis points along (0, -1, 0)"});
}

TEST(CheckObjects, HalfWidthMustBeThreeVoxels) {
  expectRefused([](FloatGrid& grid) { grid.tree().root().setBackground(float(5 * kVoxel), true); },
                {"'bad.vdb'", "half width 5 voxels", "must be 3"});
}

TEST(CheckObjects, DistancesMustBeFinite) {
  expectRefused([](FloatGrid& grid) { grid.beginValueOn().setValue(std::nanf("")); },
                {"'bad.vdb'", "nan", "must be finite"});
}

TEST(CheckObjects, LevelSetsByTheConventionsPass) {
  EXPECT_NO_THROW(checkLevelSet(*ball(), "ball"));
  // Moved by fractions of a voxel, and with sizes rounded as in a file with single precision.
  const FloatGrid::Ptr moved = ball();
  moved->transform().postTranslate({1e3, -0.03, 0.01});
  moved->transform().preScale(Vec3d(1, 1 + 1e-7, 1 - 1e-7));
  EXPECT_NO_THROW(checkLevelSet(*moved, "moved"));
}

/// A blade that is so thin that its inside falls between the points where shapes are measured.
TEST(CheckObjects, WhatIsThinnerThanAVoxelIsRefused) {
  LoadOptions coarse;
  coarse.resolution = 12;
  const Object blade = loadObject(std::string(SLICEMORPH_SOURCE) + "/assets/blade.ply", coarse).object;
  expectSays(refusal<GeometryError>([&] {
               MorphPlan({{"good", ball()}, {"blade.ply", blade.levelSet}});
             }),
             {"blade.ply", "thinner than a voxel", "--resolution"});
  // A needle along a row of voxels: no two of them have a surface between them.
  Mesh needle;
  for (int c = 0; c < 8; ++c) needle.points.emplace_back(c & 1 ? 1 : 0, c & 2 ? 0.01 : 0, c & 4 ? 0.01 : 0);
  for (const auto& q : {openvdb::Vec4I(0, 2, 3, 1), openvdb::Vec4I(4, 5, 7, 6), openvdb::Vec4I(0, 1, 5, 4),
                        openvdb::Vec4I(2, 6, 7, 3), openvdb::Vec4I(0, 4, 6, 2), openvdb::Vec4I(1, 3, 7, 5)}) {
    needle.triangles.emplace_back(q[0], q[1], q[2]);
    needle.triangles.emplace_back(q[0], q[2], q[3]);
  }
  const FloatGrid::Ptr thin = voxelise(needle, 1.0 / 12);
  expectSays(refusal<GeometryError>([&] {
               MorphPlan({{"good", ball()}, {"needle", thin}});
             }),
             {"needle", "thinner than a voxel everywhere", "--resolution"});
}

/// With infinite directions every overlap would be NaN, and no turn better than another.
TEST(CheckObjects, DirectionsMustBeFinite) {
  const double infinite = std::numeric_limits<double>::infinity();
  const Object a{"a", ball()},
      b{"b", shapes::levelSet(shapes::box({1, 0.6, 0.3}, 0.1), shapes::cube({0, 0, 0}, 1), kVoxel)};
  MorphOptions options;
  options.axis = {infinite, 0, 0};
  expectSays(refusal<InputError>([&] { MorphPlan({a, b}, options); }), {"axis is (inf, 0, 0)", "finite"});
  options.axis = {0, 0, 0};
  options.up = {0, std::nan(""), 0};
  expectSays(refusal<InputError>([&] { MorphPlan({a, b}, options); }), {"up is (0, nan, 0)", "finite"});
}

TEST(CheckObjects, ObjectsThatAreNotThereHaveNoPoints) {
  const MorphPlan plan({{"a", ball()}, {"b", ball()}});
  expectSays(refusal<InputError>([&] {
               plan.carryPoints({{1, 0, 0}}, 2, {0.5, 0.5});
             }),
             {"no object 2", "there are 2"});
  expectSays(refusal<InputError>([&] {
               plan.correspond({{1, 0, 0}}, 0, 7);
             }),
             {"no object 7", "there are 2"});
}

/// Objects that overlap nowhere, whatever the matching does: each fades at its own position.
TEST(CheckObjects, ObjectsThatNeverMeetCanBePlanned) {
  MorphOptions options;
  options.align = Align::kNone;
  const Vec3d far(60, 45, 20);
  const MorphPlan plan({{"here", ball()}, {"there", ball(far)}}, options);
  EXPECT_GT(plan.frame({1, 0}).surface->activeVoxelCount(), 0u);
  EXPECT_NO_THROW(plan.frame({0.5, 0.5}));
}

}  // namespace
}  // namespace slicemorph

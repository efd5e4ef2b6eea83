#include "engine/follow/moving_mesh.h"
#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "io/mesh/glb_writer.h"
#include "tests/support/shapes.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <random>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

constexpr double kVoxel = 0.1;

FloatGrid::Ptr ball(double voxel = kVoxel) {
  openvdb::initialize();
  return shapes::levelSet(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1.5), voxel);
}

/// A colour that is linear in the position.
Vec3s linear(const Vec3d& p) {
  return Vec3s(0.5 + 0.1 * p[0], 0.3 + 0.2 * p[1], 0.1 - 0.05 * p[2] + 0.1 * p[0]);
}

/// Colours by a function of the world position, where |distance to the unit sphere| is less than `reach`.
template <typename Function>
Vec3SGrid::Ptr colorGrid(const openvdb::math::Transform& transform, double reach, const Function& color) {
  const Vec3SGrid::Ptr grid = Vec3SGrid::create();
  grid->setTransform(transform.copy());
  auto accessor = grid->getAccessor();
  const int cells = int(3 / transform.voxelSize()[0]);
  for (auto c = openvdb::CoordBBox(Coord(-cells), Coord(cells)).begin(); c; ++c) {
    const Vec3d world = transform.indexToWorld(*c);
    if (std::abs(world.length() - 1) < reach) accessor.setValue(*c, color(world));
  }
  return grid;
}

/// Triangles of the unit ball with a colour of its own for each corner.
PolygonMesh speckledBall(double spacing) {
  const Mesh mesh = surfaceOf(*ball(spacing));
  PolygonMesh polygons;
  polygons.points = mesh.points;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> share(0, 1);
  for (const openvdb::Vec3I& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      polygons.corners.push_back(t[k]);
      polygons.colors.emplace_back(share(random), share(random), share(random));
    }
    polygons.faceStarts.push_back(std::uint32_t(polygons.corners.size()));
  }
  return polygons;
}

double distanceTo(const Vec3d& p, const PolygonMesh& mesh, size_t face, Vec3d& weights) {
  const auto corner = [&](size_t k) { return Vec3d(mesh.points[mesh.corners[3 * face + k]]); };
  const Vec3d a = corner(0), b = corner(1), c = corner(2);
  // By subdivision: independent of the closed form.
  Vec3d best(1.0 / 3), p0 = p;
  double least = 1e9, step = 1;
  const auto at = [&](const Vec3d& w) { return (w[0] * a + w[1] * b + w[2] * c - p0).length(); };
  least = at(best);
  while (step > 1e-9) {
    bool better = false;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double move = i == j ? 0 : std::min(step, best[i]);
        Vec3d next = best;
        next[i] -= move, next[j] += move;
        if (move > 0 && at(next) < least) best = next, least = at(next), better = true;
      }
    if (!better) step /= 2;
  }
  weights = best;
  return least;
}

TEST(SurfaceColors, VoxelsHaveThatOfTheNearestPlace) {
  const PolygonMesh mesh = speckledBall(0.25);
  const FloatGrid::Ptr levelSet = voxelise({mesh.points, surfaceOf(*ball(0.25)).triangles}, kVoxel);
  const Vec3SGrid::Ptr colors = colorsAround(*levelSet, mesh);
  ASSERT_TRUE(colors);
  EXPECT_EQ(colors->getName(), "Cd");
  EXPECT_TRUE(colors->tree().hasSameTopology(levelSet->tree()));
  size_t n = 0, checked = 0;
  for (auto value = colors->cbeginValueOn(); value; ++value) {
    if (n++ % 97 != 0) continue;
    const Vec3d p = levelSet->indexToWorld(value.getCoord());
    double least = 1e9;
    std::vector<std::pair<double, Vec3s>> found;
    for (size_t f = 0; f < mesh.faceCount(); ++f) {
      if ((Vec3d(mesh.points[mesh.corners[3 * f]]) - p).length() > 0.9) continue;
      Vec3d w;
      const double d = distanceTo(p, mesh, f, w);
      least = std::min(least, d);
      found.emplace_back(d, Vec3s(w[0]) * mesh.colors[3 * f] + Vec3s(w[1]) * mesh.colors[3 * f + 1] +
                                Vec3s(w[2]) * mesh.colors[3 * f + 2]);
    }
    float off = 1;
    for (const auto& [d, color] : found)  // single precision makes near ones equal
      if (d < least + 1e-5) off = std::min(off, (color - *value).length());
    EXPECT_LT(off, 2e-3) << value.getCoord();
    ++checked;
  }
  EXPECT_GT(checked, 50u);
}

TEST(SurfaceColors, AMeshWithoutHasNone) {
  PolygonMesh mesh = speckledBall(0.25);
  mesh.colors.clear();
  EXPECT_FALSE(colorsAround(*ball(), mesh));
}

/// Repair drops faces without area; one that reaches far away costs no time and colours nothing.
TEST(SurfaceColors, FacesBeyondTheSurfaceAreLeftOut) {
  PolygonMesh mesh = speckledBall(0.25);
  const Vec3SGrid::Ptr before = colorsAround(*ball(), mesh);
  mesh.points.emplace_back(1e30f, 0.f, 0.f);
  mesh.points.emplace_back(0.f, 4000.f, 0.f);
  for (std::uint32_t k : {0u, std::uint32_t(mesh.points.size() - 1), std::uint32_t(mesh.points.size() - 2)}) {
    mesh.corners.push_back(k);
    mesh.colors.emplace_back(9.f, 9.f, 9.f);
  }
  mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
  const Vec3SGrid::Ptr after = colorsAround(*ball(), mesh);
  for (auto value = before->cbeginValueOn(); value; ++value)
    ASSERT_EQ(after->tree().getValue(value.getCoord()), *value);
}

TEST(SurfaceColors, AGridIsSampledOnAnyTransform) {
  const FloatGrid::Ptr levelSet = ball();
  openvdb::math::Transform::Ptr turned = openvdb::math::Transform::createLinearTransform(0.07);
  turned->postRotate(0.6, openvdb::math::Y_AXIS);
  turned->postTranslate({0.3, -0.02, 0.1});
  const Vec3SGrid::Ptr colors = colorsAround(*levelSet, *colorGrid(*turned, 0.6, linear));
  ASSERT_TRUE(colors && colors->tree().hasSameTopology(levelSet->tree()));
  for (auto value = colors->cbeginValueOn(); value; ++value)
    ASSERT_LT((*value - linear(levelSet->indexToWorld(value.getCoord()))).length(), 1e-5);
}

TEST(SurfaceColors, WhatIsFurtherAwayTakesTheNearestVoxels) {
  const FloatGrid::Ptr levelSet = ball();
  // Half of the ball has colours; the other half is up to 20 voxels away.
  const auto given = colorGrid(levelSet->transform(), 0.25, linear);
  for (auto value = given->beginValueOn(); value; ++value)
    if (value.getCoord()[0] < 0) value.setValueOff();
  const Vec3SGrid::Ptr colors = colorsAround(*levelSet, *given);
  std::vector<Coord> sources;
  for (auto value = given->cbeginValueOn(); value; ++value)
    if (levelSet->tree().isValueOn(value.getCoord())) sources.push_back(value.getCoord());
  size_t n = 0;
  for (auto value = colors->cbeginValueOn(); value; ++value) {
    const Coord voxel = value.getCoord();
    if (voxel[0] >= 0 || n++ % 13 != 0) continue;
    Coord best;
    auto squared = [&](const Coord& c) { return (c - voxel).asVec3d().lengthSqr(); };
    for (const Coord& c : sources)
      if (squared(c) < squared(best) || best == Coord() || (squared(c) == squared(best) && c < best))
        best = c;
    ASSERT_EQ(*value, given->tree().getValue(best)) << voxel;
  }
  EXPECT_GT(n, 1000u);
  EXPECT_FALSE(colorsAround(*levelSet, *Vec3SGrid::create()));
}

TEST(SurfaceColors, PointsTakeThoseBetweenOrNearActiveVoxels) {
  const auto transform = openvdb::math::Transform::createLinearTransform(kVoxel);
  const Vec3SGrid::Ptr grid = colorGrid(*transform, 0.19, linear);  // all around every point
  const Vec3s beside(1.3f, 0.01f, 0.02f), far(5.f, 0.f, 0.f);
  std::vector<Vec3s> points{beside, far};
  for (const Vec3s& p : surfaceOf(*ball()).points) points.push_back(p);
  const std::vector<Vec3s> colors = colorsAt(*grid, points);
  EXPECT_EQ(colors[0], grid->tree().getValue(Coord(11, 0, 0)));
  EXPECT_EQ(colors[1], Vec3s(0.f));
  for (size_t i = 2; i < points.size(); ++i)
    ASSERT_LT((colors[i] - linear(Vec3d(points[i]))).length(), 1e-5) << points[i];
  // Inactive voxels do not contribute.
  const Vec3s one(0.3f, 0.1f, 0.7f);
  const auto plain = colorGrid(*transform, 0.08, [&](const Vec3d&) { return one; });
  for (const Vec3s& c : colorsAt(*plain, surfaceOf(*ball()).points)) ASSERT_EQ(c, one);
}

TEST(SurfaceColors, TheSameForAnyThreadCount) {
  const PolygonMesh mesh = speckledBall(0.1);
  const FloatGrid::Ptr levelSet = ball(0.03);
  Vec3SGrid::Ptr first;
  for (size_t threads : {1, 2, 4})
    withThreads(threads, [&] {
      const Vec3SGrid::Ptr colors = colorsAround(*levelSet, mesh);
      if (!first) first = colors;
      for (auto value = first->cbeginValueOn(); value; ++value)
        ASSERT_EQ(colors->tree().getValue(value.getCoord()), *value);
    });
}

TEST(SurfaceColors, NamesOfColors) {
  for (const char* name : {"Cd", "cd", "color", "Color", "colour", "rgb", "albedo"})
    EXPECT_TRUE(isColorName(name));
  for (const char* name : {"emission", "vel", "v", "rest", "uv", "density", ""})
    EXPECT_FALSE(isColorName(name));
}

TEST(MovingMeshColors, AreThoseOfTheirFrames) {
  const auto transform = openvdb::math::Transform::createLinearTransform(kVoxel);
  const auto grid = [&](float red) {
    return colorGrid(*transform, 0.4, [=](const Vec3d&) { return Vec3s(red, 0, 1); });
  };
  std::vector<SurfaceFrame> frames{{ball(), {1, 0}, grid(0.25f)}, {ball(), {0, 1}, grid(0.75f)}};
  const std::vector<MovingMesh> meshes = followSurfaces(frames, nullptr);
  ASSERT_EQ(meshes.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(meshes[i].colors.size(), 1u);
    ASSERT_EQ(meshes[i].colors[0].size(), meshes[i].points[0].size());
    for (const Vec3s& c : meshes[i].colors[0]) EXPECT_EQ(c, Vec3s(i ? 0.75f : 0.25f, 0, 1));
  }
  // A frame without a surface needs none, one with a surface does.
  const auto nothing = FloatGrid::create(float(kHalfWidth * kVoxel));
  nothing->setTransform(transform);
  frames.push_back({nothing, {0, 1}});
  EXPECT_EQ(followSurfaces(frames, nullptr)[0].colors.size(), 1u);
  frames[1].colors = nullptr;
  for (const MovingMesh& m : followSurfaces(frames, nullptr)) EXPECT_TRUE(m.colors.empty());
}

nlohmann::json gltfOf(const std::string& glb) {
  std::uint32_t size = 0;
  std::memcpy(&size, glb.data() + 12, sizeof size);
  return nlohmann::json::parse(glb.substr(20, size));
}

TEST(MovingMeshColors, HaveTargetsOnlyWhereTheyChange) {
  const std::vector<Vec3s> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  MovingMesh mesh{0, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}, {points, points, points}};
  const auto primitive = [&] { return gltfOf(encodeGlb({mesh}))["meshes"][0]["primitives"][0]; };
  const auto base = [&] {
    return gltfOf(encodeGlb({mesh}))["materials"][0]["pbrMetallicRoughness"].value("baseColorFactor",
                                                                                   nlohmann::json());
  };
  EXPECT_FALSE(primitive()["attributes"].contains("COLOR_0"));
  EXPECT_EQ(base()[0], 0.62);
  const size_t plain = encodeGlb({mesh}).size();
  const std::vector<Vec3s> red(4, Vec3s(1, 0, 0)), blue(4, Vec3s(0, 0, 2));
  mesh.colors = {red, red, red};
  EXPECT_TRUE(primitive()["attributes"].contains("COLOR_0"));
  EXPECT_FALSE(primitive()["targets"][0].contains("COLOR_0"));
  EXPECT_TRUE(base().empty() || base() == nlohmann::json({1, 1, 1, 1}));
  mesh.colors = {red, red, blue};
  for (int target : {0, 1}) EXPECT_TRUE(primitive()["targets"][target].contains("COLOR_0"));
  // A colour takes three floats a point and frame; the rest is text.
  EXPECT_GE(encodeGlb({mesh}).size(), plain + 3 * 4 * 12);
  const std::string glb = encodeGlb({mesh});
  const nlohmann::json gltf = gltfOf(glb);
  const size_t accessor = gltf["meshes"][0]["primitives"][0]["targets"][1]["COLOR_0"];
  const size_t view = gltf["accessors"][accessor]["bufferView"];
  float delta[3];
  std::uint32_t text = 0;
  std::memcpy(&text, glb.data() + 12, sizeof text);
  std::memcpy(delta, glb.data() + 28 + text + gltf["bufferViews"][view].value("byteOffset", 0), sizeof delta);
  EXPECT_EQ(Vec3s(delta), Vec3s(-1, 0, 1));  // of colours clamped to 1
}

}  // namespace
}  // namespace slicemorph

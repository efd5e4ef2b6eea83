#include "engine/volume/level_set.h"
#include "engine/volume/manifold.h"
#include "engine/volume/repair_mesh.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "tests/support/surface_checks.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::Vec3I;
using openvdb::Vec3s;

class Volume : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }
};

/// A level set sampled from a distance function on the given transform; `half`: half width in voxels.
template <typename Distance>
FloatGrid::Ptr sampled(const openvdb::math::Transform::Ptr& transform, int reach, double band,
                       const Distance& distance) {
  FloatGrid::Ptr grid = FloatGrid::create(float(band));
  grid->setTransform(transform);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto accessor = grid->getAccessor();
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        const double d = distance(grid->indexToWorld(Coord(x, y, z)));
        if (std::abs(d) < band) {
          accessor.setValueOn(Coord(x, y, z), float(d));
        } else {
          accessor.setValueOff(Coord(x, y, z), float(d < 0 ? -band : band));
        }
      }
    }
  }
  return grid;
}

FloatGrid::Ptr sphereGrid(const openvdb::math::Transform::Ptr& transform, int reach, double band,
                          double radius) {
  return sampled(transform, reach, band, [radius](const Vec3d& p) { return p.length() - radius; });
}

PolygonMesh polygons(std::vector<Vec3s> points, const std::vector<std::vector<unsigned>>& faces) {
  PolygonMesh mesh;
  mesh.points = std::move(points);
  for (const auto& face : faces) {
    mesh.corners.insert(mesh.corners.end(), face.begin(), face.end());
    mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
  }
  return mesh;
}

/// A cube of quads, wound outwards.
PolygonMesh cube(float size, const Vec3s& low = Vec3s(0.0f)) {
  std::vector<Vec3s> points;
  for (int i = 0; i < 8; ++i) {
    points.push_back(low + Vec3s(i & 1 ? size : 0, i & 2 ? size : 0, i & 4 ? size : 0));
  }
  return polygons(points,
                  {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
}

void append(PolygonMesh& to, const PolygonMesh& from, bool turned = false) {
  const auto first = std::uint32_t(to.points.size());
  to.points.insert(to.points.end(), from.points.begin(), from.points.end());
  for (size_t f = 0; f < from.faceCount(); ++f) {
    std::vector<std::uint32_t> face(from.corners.begin() + from.faceStarts[f],
                                    from.corners.begin() + from.faceStarts[f + 1]);
    if (turned) std::reverse(face.begin(), face.end());
    for (std::uint32_t corner : face) to.corners.push_back(first + corner);
    to.faceStarts.push_back(std::uint32_t(to.corners.size()));
  }
}

/// Latitude-longitude sphere; `from` > 0 leaves out that many rings at the top.
PolygonMesh roundMesh(double radius, unsigned rings, unsigned from) {
  PolygonMesh mesh;
  const unsigned around = 2 * rings;
  for (unsigned r = from; r <= rings; ++r) {
    const double theta = M_PI * r / rings;
    for (unsigned a = 0; a < around; ++a) {
      const double phi = 2 * M_PI * a / around;
      mesh.points.emplace_back(float(radius * std::sin(theta) * std::cos(phi)),
                               float(radius * std::sin(theta) * std::sin(phi)),
                               float(radius * std::cos(theta)));
    }
  }
  const Vec3s pole(0, 0, float(-radius));
  for (unsigned a = 0; a < around; ++a) mesh.points[mesh.points.size() - 1 - a] = pole;
  for (unsigned r = 0; r + from < rings; ++r) {
    for (unsigned a = 0; a < around; ++a) {
      const unsigned b = (a + 1) % around, row = r * around;
      for (unsigned i : {row + a, row + around + a, row + around + b, row + b}) mesh.corners.push_back(i);
      mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
    }
  }
  return mesh;
}

bool hasNote(const Notes& notes, const std::string& part) {
  return std::any_of(notes.begin(), notes.end(),
                     [&](const Note& n) { return n.sentence().find(part) != std::string::npos; });
}

template <typename Error, typename Action>
std::string messageOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("another exception: ") + error.what();
  }
  return "nothing was thrown";
}

// Repair.

TEST_F(Volume, CubeOfQuadsBecomesClosed) {
  const RepairedMesh repaired = repairMesh(cube(2));
  EXPECT_EQ(checks::closedAndManifold(repaired.mesh), "");
  EXPECT_DOUBLE_EQ(checks::volumeOf(repaired.mesh), 8);
  EXPECT_TRUE(hasNote(repaired.notes, "triangulated 6 polygons"));
}

TEST_F(Volume, ConcavePolygonsKeepTheirOutline) {
  // An L-shaped prism: a fan from its first corner would cover the notch.
  std::vector<Vec3s> points;
  const std::vector<std::pair<float, float>> outline{{2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 0}};
  for (float z : {0.0f, 1.0f}) {
    for (const auto& [x, y] : outline) points.emplace_back(x, y, z);
  }
  std::vector<std::vector<unsigned>> faces{{5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}};
  for (unsigned i = 0; i < 6; ++i) faces.push_back({i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i});
  const RepairedMesh repaired = repairMesh(polygons(points, faces));
  EXPECT_EQ(checks::closedAndManifold(repaired.mesh), "");
  EXPECT_DOUBLE_EQ(checks::volumeOf(repaired.mesh), 3);
  double area = 0;
  for (const Vec3I& t : repaired.mesh.triangles) {
    const Vec3d a(repaired.mesh.points[t[0]]), b(repaired.mesh.points[t[1]]), c(repaired.mesh.points[t[2]]);
    area += (b - a).cross(c - a).length() / 2;
  }
  EXPECT_DOUBLE_EQ(area, 3 + 3 + 8);
}

TEST_F(Volume, SoupIsWeldedAndWindingMadeToAgree) {
  PolygonMesh soup;
  const PolygonMesh whole = cube(1);
  for (size_t f = 0; f < whole.faceCount(); ++f) {
    PolygonMesh face;
    for (auto c = whole.faceStarts[f]; c < whole.faceStarts[f + 1]; ++c) {
      face.points.push_back(whole.points[whole.corners[c]]);
      face.corners.push_back(std::uint32_t(face.corners.size()));
    }
    face.faceStarts.push_back(4);
    append(soup, face, f % 3 == 1);
  }
  soup.points.emplace_back(7, 7, 7);
  append(soup, polygons({Vec3s(0.0f), Vec3s(0.0f), Vec3s(1, 0, 0)}, {{0, 1, 2}}));
  const RepairedMesh repaired = repairMesh(soup);
  EXPECT_EQ(checks::closedAndManifold(repaired.mesh), "");
  EXPECT_DOUBLE_EQ(checks::volumeOf(repaired.mesh), 1);
  EXPECT_EQ(repaired.mesh.points.size(), 8u);
  EXPECT_TRUE(hasNote(repaired.notes, "welded 19 duplicate points"));
  EXPECT_TRUE(hasNote(repaired.notes, "dropped 1 point that no face uses"));
  EXPECT_TRUE(hasNote(repaired.notes, "dropped 1 degenerate face"));
  EXPECT_TRUE(hasNote(repaired.notes, "turned 4 faces wound against"));
}

TEST_F(Volume, InsideOutShellsAreTurnedAndCavitiesTold) {
  PolygonMesh mesh;
  append(mesh, cube(4), true);
  append(mesh, cube(1, Vec3s(10.0f)));
  RepairedMesh repaired = repairMesh(mesh);
  EXPECT_TRUE(hasNote(repaired.notes, "turned 1 inside-out shell outwards"));
  EXPECT_DOUBLE_EQ(checks::volumeOf(repaired.mesh), 65);
  append(mesh, cube(1, Vec3s(1.0f)));
  repaired = repairMesh(mesh);
  EXPECT_TRUE(hasNote(repaired.notes, "1 shell is a cavity inside another: filled as solid"));
}

TEST_F(Volume, SmallHolesAreFilledLargeOnesRefused) {
  const PolygonMesh small = roundMesh(1, 32, 2);
  const RepairedMesh repaired = repairMesh(small);
  EXPECT_EQ(checks::closedAndManifold(repaired.mesh), "");
  EXPECT_TRUE(hasNote(repaired.notes, "filled 1 hole (64 edges)"));
  // The lid is flat, so the ball lacks the cap above it and is never larger.
  EXPECT_LT(checks::volumeOf(repaired.mesh), 4.0 / 3 * M_PI);
  EXPECT_GT(checks::volumeOf(repaired.mesh), 0.98 * 4.0 / 3 * M_PI);
  const std::string why = messageOf<GeometryError>([] { repairMesh(roundMesh(1, 32, 16)); });
  EXPECT_NE(why.find("the surface is open: 64 boundary edges in 1 loop"), std::string::npos) << why;
}

/// A roof whose ridge carries a fin without thickness, whose two sides are one face folded: merged, they are one face too
/// many on the ridge and two open edges. Left so, as OpenVDB takes it; the roof's volume is h (A0 + 4 Am + A1) / 6.
TEST_F(Volume, SlitsBesideFoldedFacesAreLeft) {
  const std::vector<Vec3s> points{{-1, -1, -1},  {1, -1, -1},  {1, 1, -1},    {-1, 1, -1},
                                  {-.01f, 0, 1}, {.01f, 0, 1}, {0, 0, 1.02f}, {0, 0, 1.02f}};
  const RepairedMesh repaired = repairMesh(polygons(points, {{0, 3, 2, 1},
                                                             {0, 1, 5, 4},
                                                             {1, 2, 5},
                                                             {2, 3, 4, 5},
                                                             {3, 0, 4},
                                                             {4, 5, 6},
                                                             {5, 4, 7},
                                                             {4, 6, 7},
                                                             {5, 7, 6}}));
  EXPECT_TRUE(hasNote(repaired.notes, "voxels close such slits"));
  const double volume = 2 * (4 + 4 * 1.01 * 1 + 0) / 6;
  // Edges are cut off within half a voxel of them: 24 long in all, by h^2 / 8 of area each at most.
  const double h = 0.05;
  EXPECT_NEAR(checks::volumeOf(surfaceOf(*voxelise(repaired.mesh, h))), volume, 24 * h * h / 8 + 1e-3);
}

TEST_F(Volume, OneSidedBandIsRefused) {
  std::vector<Vec3s> points;
  const unsigned count = 30;
  for (unsigned i = 0; i < count; ++i) {
    const double a = 2 * M_PI * i / count;
    for (double s : {-0.3, 0.3}) {
      const double r = 1 + s * std::cos(a / 2);
      points.emplace_back(float(r * std::cos(a)), float(r * std::sin(a)), float(s * std::sin(a / 2)));
    }
  }
  std::vector<std::vector<unsigned>> faces;
  for (unsigned i = 0; i + 1 < count; ++i) faces.push_back({2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2});
  faces.push_back({2 * count - 2, 2 * count - 1, 0, 1});
  const std::string why = messageOf<GeometryError>([&] { repairMesh(polygons(points, faces)); });
  EXPECT_NE(why.find("not orientable: 60 boundary edges in 1 loop"), std::string::npos) << why;
}

TEST_F(Volume, MeshWithoutFacesIsRefused) {
  EXPECT_NE(messageOf<GeometryError>([] { repairMesh(PolygonMesh()); }).find("no faces"), std::string::npos);
}

// voxelise and surfaceOf.

TEST_F(Volume, SphereComesBackFromVoxels) {
  const double voxel = 0.05;
  const FloatGrid::Ptr grid = voxelise(repairMesh(roundMesh(1, 200, 0)).mesh, voxel);
  EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_NEAR(grid->background(), kHalfWidth * voxel, 1e-6);
  const Mesh surface = surfaceOf(*grid);
  EXPECT_EQ(checks::closedAndManifold(surface), "");
  EXPECT_GT(checks::volumeOf(surface), 0);
  for (const Vec3s& p : surface.points) EXPECT_NEAR(p.length(), 1, voxel / 10);
}

TEST_F(Volume, AbsurdSizesAreRefusedAtOnce) {
  const Mesh ball = repairMesh(roundMesh(1, 16, 0)).mesh;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_NE(messageOf<InputError>([&] { voxelise(ball, 1e-5); }).find("voxel size of at least"),
            std::string::npos);
  EXPECT_NE(messageOf<InputError>([&] { voxelise(ball, 0); }).find("no positive number"), std::string::npos);
  EXPECT_NE(messageOf<InputError>([&] { voxelise(ball, -1); }).find("no positive number"), std::string::npos);
  EXPECT_NE(messageOf<InputError>([&] { voxelise(ball, NAN); }).find("no positive number"),
            std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  Mesh between = ball;  // away from any voxel's centre
  for (Vec3s& p : between.points) p += Vec3s(50.0f);
  EXPECT_NE(messageOf<GeometryError>([&] { voxelise(between, 100); }).find("nothing lies inside"),
            std::string::npos);
}

TEST_F(Volume, SameBytesForAnyThreadCount) {
  const Mesh ball = repairMesh(roundMesh(1, 60, 0)).mesh;
  std::vector<std::string> points, triangles, values;
  for (size_t threads : {1, 2, 4})
    withThreads(threads, [&] {
      const FloatGrid::Ptr grid = voxelise(ball, 0.02);
      const Mesh surface = surfaceOf(*grid);
      points.push_back(checks::bytesOf(surface.points));
      triangles.push_back(checks::bytesOf(surface.triangles));
      values.emplace_back();
      for (auto value = grid->cbeginValueOn(); value; ++value) {
        const float v = *value;
        values.back().append(reinterpret_cast<const char*>(&v), sizeof v);
      }
    });
  for (size_t i = 1; i < points.size(); ++i) {
    EXPECT_TRUE(values[i] == values[0]);
    EXPECT_TRUE(points[i] == points[0]);
    EXPECT_TRUE(triangles[i] == triangles[0]);
  }
}

/// White noise at the voxels of a ball: within a few thousand cells, every ambiguous and non-manifold case of
/// the mesher.
FloatGrid::Ptr noise(unsigned seed, int reach, float share) {
  std::mt19937 random(seed);
  FloatGrid::Ptr grid = FloatGrid::create(1.0f);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto accessor = grid->getAccessor();
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        const float value = float(random() >> 8) / float(1 << 24) - share;
        accessor.setValue(Coord(x, y, z), value);
      }
    }
  }
  return grid;
}

TEST_F(Volume, NoiseMeshesAreClosedAndManifold) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (float share : {0.1f, 0.3f, 0.5f, 0.7f}) {
      const FloatGrid::Ptr grid = noise(seed, 9, share);
      const Mesh mesh = surfaceOf(*grid);
      ASSERT_EQ(checks::closedAndManifold(mesh), "") << "seed " << seed << " share " << share;
      ASSERT_EQ(checks::distinctPoints(mesh), "") << "seed " << seed << " share " << share;
      EXPECT_GT(checks::volumeOf(mesh), 0);
    }
  }
}

TEST_F(Volume, BinaryNoiseMeshesAreClosedAndManifold) {
  // Two values only: points coincide and voxels touch along edges and at corners.
  for (unsigned seed = 0; seed < 20; ++seed) {
    const FloatGrid::Ptr grid = noise(seed, 9, 0.4f);
    for (auto value = grid->beginValueOn(); value; ++value)
      value.setValue(*value < 0 ? -1.0f : (seed % 2 ? 1.0f : 0.0f));
    const Mesh mesh = surfaceOf(*grid);
    ASSERT_EQ(checks::closedAndManifold(mesh), "") << "seed " << seed;
    ASSERT_EQ(checks::distinctPoints(mesh), "") << "seed " << seed;
  }
}

TEST_F(Volume, BodiesTouchingAtAnEdgeAndAtAPointAreParted) {
  PolygonMesh touching = cube(1);
  append(touching, cube(1, Vec3s(1, 1, 0)));
  append(touching, cube(1, Vec3s(-1, -1, -1)));
  const Mesh joined = repairMesh(touching).mesh;
  EXPECT_NE(checks::closedAndManifold(joined), "");
  const Mesh parted = makeManifold(joined).mesh;
  EXPECT_EQ(checks::closedAndManifold(parted), "");
  EXPECT_EQ(checks::distinctPoints(parted), "");
  EXPECT_NEAR(checks::volumeOf(parted), 3, 0.1);
  Mesh open = joined;
  open.triangles.pop_back();
  EXPECT_THROW(makeManifold(open), GeometryError);
}

// toLevelSet.

TEST_F(Volume, CanonicalLevelSetIsSharedNotCopied) {
  const auto transform = openvdb::math::Transform::createLinearTransform(0.1);
  transform->postTranslate(Vec3d(0.03, 5, -2));
  const FloatGrid::Ptr grid =
      sampled(transform, 24, 0.3, [](const Vec3d& p) { return (p - Vec3d(0.03, 5, -2)).length() - 1; });
  const LevelSetInput input = toLevelSet(grid);
  EXPECT_EQ(input.grid.get(), grid.get());
  EXPECT_TRUE(input.notes.empty());
  const LevelSetInput finer = toLevelSet(grid, 0.05);
  EXPECT_NE(finer.grid.get(), grid.get());
  EXPECT_DOUBLE_EQ(finer.grid->voxelSize().x(), 0.05);
}

void expectBall(const FloatGrid& grid, double radius, double tolerance) {
  const Mesh surface = surfaceOf(grid);
  ASSERT_EQ(checks::closedAndManifold(surface), "");
  EXPECT_GT(checks::volumeOf(surface), 0);
  for (const Vec3s& p : surface.points) ASSERT_NEAR(p.length(), radius, tolerance);
}

TEST_F(Volume, WildGridsBecomeLevelSets) {
  const auto plain = openvdb::math::Transform::createLinearTransform(0.1);
  const auto odd = openvdb::math::Transform::createLinearTransform(1.0);
  odd->preScale(Vec3d(0.1, 0.08, 0.12));
  odd->postRotate(0.7, openvdb::math::X_AXIS);
  const auto mirrored = openvdb::math::Transform::createLinearTransform(1.0);
  mirrored->preScale(Vec3d(-0.1, 0.1, 0.1));
  const double radius = 1.3, half = 0.05;  // half a voxel

  const std::vector<std::pair<std::string, FloatGrid::Ptr>> grids{
      {"rotated, not uniform", sphereGrid(odd, 24, 0.4, radius)},
      {"mirrored", sphereGrid(mirrored, 24, 0.3, radius)},
      {"wide band", sphereGrid(plain, 24, 0.8, radius)},
      {"dense", sphereGrid(plain, 24, 100, radius)},
      {"in voxel units", sampled(plain, 24, 3, [&](const Vec3d& p) { return (p.length() - radius) / 0.1; })},
  };
  for (const auto& [name, grid] : grids) {
    const LevelSetInput input = toLevelSet(grid);
    EXPECT_EQ(input.notes.size(), 1u) << name;
    EXPECT_NEAR(input.grid->background(), 3 * input.grid->voxelSize().x(), 1e-6) << name;
    SCOPED_TRACE(name);
    expectBall(*input.grid, radius, half);
  }
}

TEST_F(Volume, FogIsInsideAboveTheIsoValue) {
  const auto plain = openvdb::math::Transform::createLinearTransform(0.1);
  const FloatGrid::Ptr fog = FloatGrid::create(0.0f);
  fog->setTransform(plain);
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  const FloatGrid::Ptr ball = sphereGrid(plain, 24, 100, 1.3);
  for (auto value = ball->cbeginValueOn(); value; ++value) {
    const float density = std::clamp(-*value / 0.4f + 0.5f, 0.0f, 1.0f) * 2;
    if (density > 0) fog->tree().setValue(value.getCoord(), density);
  }
  expectBall(*toLevelSet(fog).grid, 1.3, 0.05);
  expectBall(*toLevelSet(fog, 0, 0.5).grid, 1.4, 0.05);
}

TEST_F(Volume, GridsWithoutASurfaceAreRefused) {
  const FloatGrid::Ptr empty = FloatGrid::create(0.3f);
  empty->setGridClass(openvdb::GRID_LEVEL_SET);
  EXPECT_NE(messageOf<GeometryError>([&] { toLevelSet(empty); }).find("empty"), std::string::npos);
  const FloatGrid::Ptr far = FloatGrid::create(0.0f);
  far->setGridClass(openvdb::GRID_LEVEL_SET);
  far->fill(openvdb::CoordBBox(Coord(0), Coord(20)), 10000.0f);
  const std::string why = messageOf<GeometryError>([&] { toLevelSet(far); });
  EXPECT_NE(why.find("no surface at 0: its values run from 10000 to 10000"), std::string::npos) << why;
  far->tree().setValue(Coord(3), std::nanf(""));
  EXPECT_NE(messageOf<GeometryError>([&] { toLevelSet(far); }).find("not finite"), std::string::npos);
}

TEST_F(Volume, LevelSetCutOffByItsGridIsClosed) {
  // A dense field whose inside extends to the last active voxel.
  const auto plain = openvdb::math::Transform::createLinearTransform(0.1);
  const FloatGrid::Ptr cut = sphereGrid(plain, 9, 100, 1.3);
  const LevelSetInput input = toLevelSet(cut);
  EXPECT_EQ(checks::closedAndManifold(surfaceOf(*input.grid)), "");
  EXPECT_GT(checks::volumeOf(surfaceOf(*input.grid)), 0);
}

}  // namespace
}  // namespace slicemorph

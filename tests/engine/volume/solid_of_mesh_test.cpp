#include "engine/volume/solid_of_mesh.h"

#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "tests/support/surface_checks.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace slicemorph {
namespace {

using openvdb::Vec3s;
using Corners = std::vector<std::vector<Vec3d>>;  ///< faces, each by its corners: nothing is shared

PolygonMesh soupOf(const Corners& faces) {
  PolygonMesh mesh;
  for (const auto& face : faces) {
    for (const Vec3d& p : face) {
      mesh.corners.push_back(std::uint32_t(mesh.points.size()));
      mesh.points.emplace_back(p);
    }
    mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
  }
  return mesh;
}

/// A ball of quads, wound outwards, without the faces that `skip` names by the direction of their middle.
Corners ball(
    double radius, const Vec3d& centre = Vec3d(0.0),
    const std::function<bool(const Vec3d&)>& skip = [](const Vec3d&) { return false; }) {
  constexpr int kRings = 48;
  const auto at = [&](int ring, int turn) {
    const double theta = M_PI * ring / kRings, phi = M_PI * (turn % (2 * kRings)) / kRings;
    if (ring == 0 || ring == kRings) return Vec3d(0, 0, ring == 0 ? 1 : -1);
    return Vec3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
  };
  Corners faces;
  for (int r = 0; r < kRings; ++r)
    for (int a = 0; a < 2 * kRings; ++a) {
      std::vector<Vec3d> face{at(r, a), at(r + 1, a), at(r + 1, a + 1), at(r, a + 1)};
      if (skip((face[0] + face[1] + face[2] + face[3]) / 4)) continue;
      for (Vec3d& p : face) p = centre + radius * p;
      faces.push_back(std::move(face));
    }
  return faces;
}

Corners box(const Vec3d& low, const Vec3d& high) {
  const auto at = [&](int i) {
    return Vec3d((i & 1 ? high : low)[0], (i & 2 ? high : low)[1], (i & 4 ? high : low)[2]);
  };
  Corners faces;
  for (const auto& f :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    faces.push_back({at(f[0]), at(f[1]), at(f[2]), at(f[3])});
  return faces;
}

/// A graph over a square of quads, 2 wide.
Corners graph(int cells, const std::function<double(double, double)>& height) {
  Corners faces;
  const auto at = [&](int i, int j) {
    const double x = 2.0 * i / cells - 1, y = 2.0 * j / cells - 1;
    return Vec3d(x, y, height(x, y));
  };
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  return faces;
}

Corners turned(Corners faces) {
  for (auto& face : faces) std::reverse(face.begin(), face.end());
  return faces;
}

Corners together(Corners a, const Corners& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

MeshSolid solid(const Corners& faces, double voxelSize, double shell = 0) {
  SolidOptions options;
  options.voxelSize = voxelSize, options.shell = shell;
  return solidOf(prepareSolid(soupOf(faces)), options);
}

double volume(const MeshSolid& solid) { return checks::volumeOf(surfaceOf(*solid.levelSet)); }

bool noted(const MeshSolid& solid, const std::string& code) {
  return std::any_of(solid.notes.begin(), solid.notes.end(), [&](const Note& n) { return n.code == code; });
}

template <typename Error>
std::string refusalOf(const Corners& faces, double voxelSize, double shell = 0) {
  try {
    solid(faces, voxelSize, shell);
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("another exception: ") + error.what();
  }
  return "nothing was thrown";
}

class Solid : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }
};

constexpr double kVoxel = 0.04, kBall = 4.0 / 3 * M_PI;
/// A twentieth of a voxel over a unit ball's area, for the meshes are within a twentieth (a chord of 2 pi / 96 has a sagitta of
/// 5e-4) and a smooth surface comes back from voxels as exactly (SphereComesBackFromVoxels in volume_test).
constexpr double kBallTolerance = 4 * M_PI * kVoxel / 20;

/// The whole of what is clean and closed stays as it was, to the byte.
TEST_F(Solid, CleanClosedMeshesGoTheirOldWay) {
  const PolygonMesh mesh = soupOf(ball(1));
  SolidOptions options;
  options.voxelSize = kVoxel;
  const FloatGrid::Ptr old = voxelise(repairMesh(mesh).mesh, kVoxel),
                       now = solidOf(prepareSolid(mesh), options).levelSet;
  ASSERT_EQ(old->activeVoxelCount(), now->activeVoxelCount());
  for (auto a = old->cbeginValueOn(), b = now->cbeginValueOn(); a; ++a, ++b) {
    ASSERT_EQ(a.getCoord(), b.getCoord());
    ASSERT_EQ(*a, *b);
  }
}

/// Where an eighth of the faces is missing here and there, the ball is still whole: the surface across each hole passes where
/// the missing piece would fill half of the view, near the piece.
TEST_F(Solid, MissingFacesAreClosed) {
  int n = 0;
  const MeshSolid holes = solid(
      ball(1, Vec3d(0.0), [&](const Vec3d& d) { return std::abs(d[2]) < 0.9 && n++ % 8 == 0; }), kVoxel);
  EXPECT_EQ(checks::closedAndManifold(surfaceOf(*holes.levelSet)), "");
  EXPECT_NEAR(volume(holes), kBall, 2 * kBallTolerance);
}

/// A hemisphere's open side closes in the plane of its rim, from whose points it fills half of the view.
TEST_F(Solid, AHemisphereIsHalfABall) {
  const MeshSolid half = solid(ball(1, Vec3d(0.0), [](const Vec3d& d) { return d[2] < 0; }), kVoxel);
  EXPECT_TRUE(noted(half, "mesh.by-winding"));
  // The plane is exact to a twentieth of a voxel, too; the edge is cut by h^2 / 8 along it.
  EXPECT_NEAR(volume(half), kBall / 2, 3 * M_PI * kVoxel / 20 + 2 * M_PI * kVoxel * kVoxel / 8);
  for (const Vec3s& p : surfaceOf(*half.levelSet).points) EXPECT_GT(p[2], -kVoxel / 2);
}

TEST_F(Solid, FlippedAndDoubledPatchesAreRight) {
  const auto upper = [](const Vec3d& d) { return d[2] > 0; };
  const auto lower = [](const Vec3d& d) { return d[2] < 0; };
  const auto inBand = [](const Vec3d& d) { return std::abs(d[2]) > 0.4; };
  // A cut along the equator, as wide as a few faces, keeps the flipped half apart.
  const auto top = ball(1, Vec3d(0.0), lower), bottom = ball(0.999, Vec3d(0.0), upper);
  EXPECT_NEAR(volume(solid(together(top, turned(bottom)), kVoxel)), kBall, kBallTolerance);
  EXPECT_NEAR(volume(solid(turned(together(top, bottom)), kVoxel)), kBall, kBallTolerance);
  // A belt lies around it a second time, hardly outside.
  const MeshSolid belted = solid(together(top, together(bottom, ball(1.001, Vec3d(0.0), inBand))), kVoxel);
  EXPECT_NEAR(volume(belted), kBall, kBallTolerance);
}

/// Two unit balls whose centres are 1 apart share a lens of 5 pi / 12.
TEST_F(Solid, IntersectingShellsAreOneBody) {
  const Corners both = together(ball(1), ball(1, Vec3d(1, 0, 0)));
  const double expected = 2 * kBall - 5 * M_PI / 12;
  EXPECT_NEAR(volume(solid(both, kVoxel)), expected, 2 * kBallTolerance + 2 * M_PI * kVoxel * kVoxel);
  // The same with a hole in one of them, which is then told by winding numbers.
  const Corners open =
      together(ball(1, Vec3d(0.0), [](const Vec3d& d) { return d[0] < -0.5; }), ball(1, Vec3d(1, 0, 0)));
  const MeshSolid cut = solid(open, kVoxel);
  EXPECT_TRUE(noted(cut, "mesh.by-winding"));
  // The cap beyond x = -1/2 is missing: pi (1 - a)^2 (2 + a) / 3 with a = 1/2; winding numbers bulge a little into it.
  const double missing = M_PI * 0.25 * 2.5 / 3;
  EXPECT_GT(volume(cut), expected - missing - 2 * kBallTolerance - 2 * M_PI * kVoxel * kVoxel);
  EXPECT_LT(volume(cut), expected + 2 * kBallTolerance);
}

TEST_F(Solid, CavitiesAreKeptWhereTheyAreWoundSo) {
  const double inner = kBall / 8;
  const MeshSolid hollow = solid(together(ball(1), turned(ball(0.5))), kVoxel);
  EXPECT_TRUE(noted(hollow, "mesh.by-winding"));
  EXPECT_NEAR(volume(hollow), kBall - inner, 1.5 * kBallTolerance);
  EXPECT_NEAR(volume(solid(turned(together(ball(1), turned(ball(0.5)))), kVoxel)), kBall - inner,
              1.5 * kBallTolerance);
  // Wound the same way it is one body with another in it.
  EXPECT_NEAR(volume(solid(together(ball(1), ball(0.5)), kVoxel)), kBall, kBallTolerance);
  // A body in a cavity in a body.
  const Corners nested = together(together(ball(1), turned(ball(0.7))), ball(0.4));
  EXPECT_NEAR(volume(solid(nested, kVoxel)), kBall * (1 - 0.343 + 0.064), 2.5 * kBallTolerance);
}

/// Six quads that do not touch: each alone is a sheet, together they are a box.
TEST_F(Solid, QuadsThatDoNotTouchAreACube) {
  for (bool flip : {false, true}) {
    Corners cube = box(Vec3d(-1.0), Vec3d(1.0));
    for (size_t f = 0; f < cube.size(); ++f) {
      const Vec3d middle = (cube[f][0] + cube[f][2]) / 2;
      for (Vec3d& p : cube[f]) p = middle + 0.99 * (p - middle);
      if (flip && f % 2 == 0) std::reverse(cube[f].begin(), cube[f].end());
    }
    // Edges are cut off within a voxel, 24 long in all; the slits there are a hundredth wide.
    EXPECT_NEAR(volume(solid(cube, kVoxel)), 8, 24 * kVoxel * kVoxel) << flip;
  }
}

TEST_F(Solid, SheetsAreRefusedWithAThicknessThatDoes) {
  std::vector<Vec3d> rim;
  Corners band;
  for (int i = 0; i < 60; ++i) {
    const auto at = [](int k, double s) {
      const double a = 2 * M_PI * k / 60, r = 1 + s * std::cos(a / 2);
      return Vec3d(r * std::cos(a), r * std::sin(a), s * std::sin(a / 2));
    };
    band.push_back({at(i, -0.3), at(i, 0.3), at(i + 1, 0.3), at(i + 1, -0.3)});
  }
  const Corners plane = graph(8, [](double, double) { return 0.0; });
  const Corners leaf =
      graph(16, [](double x, double y) { return 0.1 * (x * x - 0.5 * y * y) + 0.05 * std::sin(3 * x); });
  for (const Corners& sheet : {plane, leaf, band}) {
    const std::string why = refusalOf<GeometryError>(sheet, kVoxel);
    EXPECT_NE(why.find("encloses nothing: --shell 0.1 makes it a solid"), std::string::npos) << why;
    EXPECT_NO_THROW(solid(sheet, kVoxel, 0.1));
    EXPECT_NE(
        refusalOf<InputError>(sheet, kVoxel, 0.05).find("--shell 0.05 is less than 1.75 voxels of 0.04"),
        std::string::npos);
  }
  EXPECT_NE(refusalOf<InputError>(plane, kVoxel, -1).find("--shell -1 is no positive thickness"),
            std::string::npos);
}

/// All points within r of a square of side 2: 4 * 2r, half a cylinder of radius r along each side, a quarter of a ball in all
/// at its corners twice over.
TEST_F(Solid, ShellsHaveTheirThickness) {
  const double r = 0.1;
  const MeshSolid plate = solid(graph(4, [](double, double) { return 0.013; }), kVoxel, 2 * r);
  const double exact = 4 * 2 * r + 4 * 2 * M_PI * r * r / 2 + kBall * r * r * r;
  EXPECT_NEAR(volume(plate), exact, (8 + 8 * M_PI * r) * kVoxel / 20);
  EXPECT_EQ(plate.levelSet->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_NEAR(plate.levelSet->background(), kHalfWidth * kVoxel, 1e-6);
}

TEST_F(Solid, SheetsBesideABodyAreLeftOutOrThickened) {
  Corners hair = graph(2, [](double, double) { return 1.5; });
  for (auto& face : hair)
    for (Vec3d& p : face) p[1] *= 0.2;
  const Corners head = together(ball(1), hair);
  const MeshSolid bald = solid(head, kVoxel);
  EXPECT_NEAR(volume(bald), kBall, kBallTolerance);
  EXPECT_NE(bald.notes.at(0).text.find(
                "1 of 2 shells is a sheet that encloses nothing (area 0.8): left out; --shell 0.1"),
            std::string::npos)
      << bald.notes.at(0).text;
  const double r = 0.1;
  const double lock = 0.8 * 2 * r + (2 + 0.4) * M_PI * r * r + kBall * r * r * r;
  EXPECT_NEAR(volume(solid(head, kVoxel, 2 * r)), kBall + lock,
              kBallTolerance + (1.6 + 4.8 * M_PI * r) * kVoxel / 20);
}

TEST_F(Solid, RepairsAreToldInOneLine) {
  const MeshSolid one = solid(ball(1, Vec3d(0.0), [](const Vec3d& d) { return d[2] < 0; }), kVoxel);
  size_t lines = 0;
  for (const Note& note : one.notes) lines += note.severity != Severity::kDetail;
  EXPECT_EQ(lines, 1u);
  EXPECT_EQ(one.notes.at(0).code, "mesh.repaired");
  EXPECT_EQ(one.notes.at(0).severity, Severity::kWarning) << "a hole as large as this is worth a warning";
}

TEST_F(Solid, SameBytesForAnyThreadCount) {
  const Corners faces =
      together(ball(1, Vec3d(0.0), [](const Vec3d& d) { return d[2] < 0.2; }), ball(0.6, Vec3d(0.7, 0, 0.5)));
  std::vector<std::string> values;
  for (size_t threads : {1, 2, 4})
    withThreads(threads, [&] {
      values.emplace_back();
      const MeshSolid made = solid(faces, kVoxel);
      for (auto value = made.levelSet->cbeginValueOn(); value; ++value) {
        const float v = *value;
        values.back().append(reinterpret_cast<const char*>(&v), sizeof v);
      }
    });
  EXPECT_TRUE(values[0] == values[1]);
  EXPECT_TRUE(values[0] == values[2]);
}

}  // namespace
}  // namespace slicemorph

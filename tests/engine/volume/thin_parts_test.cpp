// What of a mesh falls between the voxels, against shares of area that are known.
#include "engine/volume/thin_parts.h"

#include "engine/volume/small_components.h"
#include "engine/volume/solid_of_mesh.h"
#include "engine/volume/voxelise.h"
#include "tests/support/same_values.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>

namespace slicemorph {
namespace {

constexpr double kVoxelOfParts = 0.04;

void addBlock(PolygonMesh& mesh, const Vec3d& low, const Vec3d& high) {
  const auto first = std::uint32_t(mesh.points.size());
  for (int c = 0; c < 8; ++c)
    mesh.points.emplace_back(c & 1 ? high[0] : low[0], c & 2 ? high[1] : low[1], c & 4 ? high[2] : low[2]);
  for (const auto& face : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                           {4, 5, 7, 6},
                           {0, 1, 5, 4},
                           {2, 6, 7, 3},
                           {0, 4, 6, 2},
                           {1, 3, 7, 5}}) {
    for (std::uint32_t corner : face) mesh.corners.push_back(first + corner);
    mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
  }
}

/// A cube of side 1, and above it a square plate of side 1 from `low` to `high`.
PolygonMesh cubeAndPlate(double low, double high) {
  PolygonMesh mesh;
  addBlock(mesh, {0, 0, 0}, {1, 1, 1});
  addBlock(mesh, {0, 0, low}, {1, 1, high});
  return mesh;
}

double lostOf(const PolygonMesh& polygons) {
  const Mesh mesh = prepareSolid(polygons).mesh;
  return lostShare(mesh, *voxelise(mesh, kVoxelOfParts));
}

/// A plate between two layers of voxels is lost, and nothing else. 20,000 points tell areas of 24 triangles to half a
/// point each.
TEST(ThinParts, ArePlatesBetweenTheVoxels) {
  const double thick = 0.1 * kVoxelOfParts, middle = 50.5 * kVoxelOfParts;
  const double plate = 2 + 4 * thick;
  EXPECT_NEAR(lostOf(cubeAndPlate(middle - thick / 2, middle + thick / 2)), plate / (6 + plate),
              24 * 0.5 / 20000);
  PolygonMesh cube;
  addBlock(cube, {0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(lostOf(cube), 0);
}

/// However it lies between the layers, a plate of a voxel and a half is there, but for its rim, which is narrower than two.
TEST(ThinParts, PlatesOfMoreThanAVoxelAreNone) {
  const double rim = 4 * 1.5 * kVoxelOfParts;
  for (double shift : {0.0, 0.2, 0.5, 0.9}) {
    const double low = (50 + shift) * kVoxelOfParts;
    EXPECT_LT(lostOf(cubeAndPlate(low, low + 1.5 * kVoxelOfParts)), rim / (8 + rim)) << shift;
  }
}

/// Two cubes of side .5, too small for inside tiles, joined by a plate of a tenth of a voxel, shifted by this many voxels from their bottom.
PolygonMesh joinedCubes(double shift) {
  PolygonMesh mesh;
  const double low = (6 + shift) * kVoxelOfParts;
  addBlock(mesh, {0, 0, 0}, {0.5, 0.5, 0.5});
  addBlock(mesh, {0.4, 0.1, low}, {1.1, 0.4, low + 0.1 * kVoxelOfParts});
  addBlock(mesh, {1, 0, 0}, {1.5, 0.5, 0.5});
  return mesh;
}

/// However it lies between the voxels, a plate that joins two parts is kept, as thick as told to within a voxel.
TEST(ThinParts, ThatJoinOthersAreKept) {
  SolidOptions options;
  options.voxelSize = kVoxelOfParts;
  for (double shift : {0.1, 0.3, 0.6}) {
    const FloatGrid::Ptr grid = solidOf(prepareSolid(joinedCubes(shift)), options).levelSet;
    EXPECT_EQ(countPieces(*grid), 1) << shift;
    const Vec3d middle(0.75, 0.25, (6.05 + shift) * kVoxelOfParts);
    for (double z = -2; z <= 2; z += 0.25) {
      const Vec3d p = middle + Vec3d(0, 0, z * kVoxelOfParts);
      const double value = openvdb::tools::BoxSampler::sample(grid->tree(), grid->worldToIndex(p));
      EXPECT_NEAR(value, (std::abs(z) - kKeptWall / 2) * kVoxelOfParts, kVoxelOfParts) << shift << " " << z;
    }
  }
}

/// A plate that joins nothing changes nothing: the level set is OpenVDB's.
TEST(ThinParts, ThatJoinNothingAreLost) {
  SolidOptions options;
  options.voxelSize = kVoxelOfParts;
  const PolygonMesh polygons = cubeAndPlate(50.4 * kVoxelOfParts, 50.6 * kVoxelOfParts);
  EXPECT_TRUE(sameValues(*solidOf(prepareSolid(polygons), options).levelSet,
                         *voxelise(prepareSolid(polygons).mesh, kVoxelOfParts)));
}

TEST(ThinParts, AreTold) {
  const auto isTold = [](const PolygonMesh& mesh) {
    SolidOptions options;
    options.voxelSize = kVoxelOfParts;
    const Notes notes = solidOf(prepareSolid(mesh), options).notes;
    return std::any_of(notes.begin(), notes.end(),
                       [](const Note& note) { return note.code == "mesh.thin-walls"; });
  };
  EXPECT_TRUE(isTold(cubeAndPlate(50.4 * kVoxelOfParts, 50.6 * kVoxelOfParts)));
  EXPECT_FALSE(isTold(cubeAndPlate(50 * kVoxelOfParts, 53 * kVoxelOfParts)));
}

}  // namespace
}  // namespace slicemorph

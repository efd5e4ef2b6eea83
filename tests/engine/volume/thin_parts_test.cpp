// What of a mesh falls between the voxels, against shares of area that are known.
#include "engine/volume/thin_parts.h"

#include "engine/volume/solid_of_mesh.h"
#include "engine/volume/voxelise.h"

#include <gtest/gtest.h>

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

#include "engine/rebuild/image_nodes.h"
#include "engine/spine/chart.h"

#include <gtest/gtest.h>

#include <random>

namespace slicemorph {
namespace {

/// Oblique, with a different spacing along each axis.
ImageLattice oblique() {
  const Mat3d turn = rotationFromVector({0.2, -0.4, 0.7});
  ImageLattice lattice{{23, 11, 8}, {10, -4, 3}};
  const double side[3] = {0.5, 0.8, 1.7};
  for (int d = 0; d < 3; ++d) lattice.step[d] = side[d] * turn.col(d);
  return lattice;
}

/// A map that leaves the object where it is.
Carrying still(const Vec3d& anchor) {
  Carrying carrying;
  carrying.anchor = anchor;
  return carrying;
}

TEST(ImageNodes, ARowOfVoxelsLiesWhereItsImageHasIt) {
  const ImageLattice lattice = oblique();
  const Vec3d anchor(9, -2, 4);
  const ImageNodes nodes = imageNodes(lattice, still(anchor), 3.2);
  EXPECT_EQ(nodes.step, openvdb::Vec3i(6, 4, 2));  // 3.2 over 0.5, 0.8 and 1.7, rounded
  PositionRow row(nodes, 0);
  for (int k = 0; k < lattice.size[2]; ++k)
    for (int j = 0; j < lattice.size[1]; ++j) {
      row.begin(0, lattice.size[0] - 1, j, k);
      for (int i = 0; i < lattice.size[0]; ++i) {
        const PositionRow::Stretch stretch = row.from(i);
        EXPECT_EQ(stretch.length, 6 - i % 6);
        for (int n = 0; n < stretch.length && i + n < lattice.size[0]; ++n)
          ASSERT_LE(
              (Vec3d(stretch.at + stretch.step * float(n)) + anchor - lattice.toWorld(Vec3d(i + n, j, k)))
                  .length(),
              1e-4);
      }
    }
}

/// Nodes at random positions: between them, positions are trilinear.
TEST(ImageNodes, PositionsAreLinearBetweenNodes) {
  ImageNodes nodes = imageNodes(oblique(), still({0, 0, 0}), 3.2);
  std::mt19937 random(2);
  for (openvdb::Vec3s& v : nodes.map.at)
    for (int a = 0; a < 3; ++a) v[a] = std::uniform_real_distribution<float>(-1, 1)(random);
  PositionRow row(nodes, 0);
  for (int k : {0, 3, 7})
    for (int j : {0, 4, 10}) {
      row.begin(5, 17, j, k);
      for (int i = 5; i <= 17; ++i) {
        Vec3d wanted(0.0);
        for (int c = 0; c < 8; ++c) {
          const int n[3] = {i / 6 + (c & 1), j / 4 + (c >> 1 & 1), k / 2 + (c >> 2)};
          const double hat = (1 - std::abs(i / 6.0 - n[0])) * (1 - std::abs(j / 4.0 - n[1])) *
                             (1 - std::abs(k / 2.0 - n[2]));
          wanted += hat * Vec3d(nodes.map.at[nodes.map.index(n[0], n[1], n[2])]);
        }
        EXPECT_LE((Vec3d(row.from(i).at) - wanted).length(), 1e-5) << i << " " << j << " " << k;
      }
    }
}

TEST(ImageNodes, PositionsAreFoundBackInTheImage) {
  const ImageLattice lattice = oblique();
  const Vec3d anchor(9, -2, 4);
  const PositionToVoxel toVoxel(lattice, anchor);
  for (const Vec3d& voxel : {Vec3d(0, 0, 0), Vec3d(3, 7, 1), Vec3d(-2, 0.5, 9)}) {
    EXPECT_LE((Vec3d(toVoxel(openvdb::Vec3s(lattice.toWorld(voxel) - anchor))) - voxel).length(), 1e-4);
    const Vec3d vector = lattice.toWorld(voxel) - lattice.toWorld(Vec3d(0.0));
    EXPECT_LE((Vec3d(toVoxel.vector(openvdb::Vec3s(vector))) - voxel).length(), 1e-4);
  }
}

}  // namespace
}  // namespace slicemorph

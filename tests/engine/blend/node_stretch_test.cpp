#include "engine/blend/node_stretch.h"
#include "engine/spine/chart.h"

#include <gtest/gtest.h>
#include <Eigen/SVD>

#include <random>

namespace slicemorph {
namespace {

Eigen::Matrix3d eigenOf(const Mat3d& m) {
  Eigen::Matrix3d e;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) e(i, j) = m(i, j);
  return e;
}

/// U V^T of the singular value decomposition.
Eigen::Matrix3d polarFactor(const Mat3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(eigenOf(m), Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

TEST(NodeStretch, TheNearestRotationIsThePolarFactor) {
  std::mt19937 random(6);
  std::uniform_real_distribution<> uniform(-1, 1);
  for (int repeat = 0; repeat < 100; ++repeat) {
    Mat3d m;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m(i, j) = uniform(random);
    if (m.det() < 0) m = -m;
    if (m.det() < 0.02) continue;  // its twelve rounds are for maps that do not nearly fold
    EXPECT_LE((eigenOf(polarRotation(m)) - polarFactor(m)).norm(), 1e-6) << m;
  }
  EXPECT_EQ(polarRotation(Mat3d(-1, 0, 0, 0, 1, 0, 0, 0, 1)), Mat3d::identity());
}

/// Nodes of an affine map p -> m p + offset from voxels of an in-between, `step` of them apart.
NodeMap affineNodes(const Mat3d& m, int step) {
  NodeMap nodes;
  nodes.step = step, nodes.origin = {-2, 1, 3}, nodes.size = {4, 5, 3}, nodes.objects = 2;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 4; ++i) {
        nodes.at.push_back(openvdb::Vec3s(0.f));
        nodes.at.push_back(
            openvdb::Vec3s(m * (step * (nodes.origin + openvdb::Coord(i, j, k)).asVec3d()) + Vec3d(1, 2, 3)));
        nodes.known.push_back(1);
      }
  return nodes;
}

TEST(NodeStretch, AffineMapsTurnAndStretchAlikeEverywhere) {
  const double voxel = 0.25;
  const Mat3d world =
      rotationFromVector({0.3, -0.5, 0.9}) * Mat3d(1.5, 0.2, 0.0, 0.0, 0.8, -0.1, 0.3, 0.0, 1.1);
  NodeMap nodes = affineNodes(world * voxel, 4);
  const NodeStretch stretch(nodes, 1, Mat3d::identity() * (1 / voxel));
  for (int i : {-2, -1, 0})
    for (int j : {1, 3}) {
      const NodeStretch::Local local = stretch.at(i, j, 3, {0.25f, 0.5f, 0.75f});
      EXPECT_NEAR(local.volume, world.det(), 1e-4);
      EXPECT_LE((eigenOf(Mat3d(local.rotation)) - polarFactor(world)).norm(), 1e-4);
    }
  // Next to an unknown node the differences are one-sided.
  const size_t unknown = nodes.index(0, 3, 4);
  nodes.known[unknown] = 0;
  nodes.at[2 * unknown + 1] = openvdb::Vec3s(1e6f);
  const NodeStretch rim(nodes, 1, Mat3d::identity() * (1 / voxel));
  EXPECT_NEAR(rim.at(-1, 3, 4, {0, 0, 0}).volume, world.det(), 1e-4);
}

TEST(NodeStretch, AFoldHasNoVolume) {
  const NodeMap nodes = affineNodes(Mat3d(-1, 0, 0, 0, 1, 0, 0, 0, 1), 2);
  EXPECT_EQ(NodeStretch(nodes, 1, Mat3d::identity()).at(-1, 2, 3, {0.5f, 0.5f, 0.5f}).volume, 0);
}

}  // namespace
}  // namespace slicemorph

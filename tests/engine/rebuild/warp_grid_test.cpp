// Grids carried by hand-made node maps: shifts, turns and scales in closed form.
#include "engine/rebuild/warp_grid.h"
#include "engine/spine/chart.h"
#include "slicemorph/errors.h"
#include "tests/support/fields.h"

#include <gtest/gtest.h>
#include <openvdb/tools/ChangeBackground.h>

#include <cmath>

namespace slicemorph {
namespace {

using Transform = openvdb::math::Transform;

constexpr double kWarpVoxel = 0.1;
const openvdb::CoordBBox kWarpBox({-20, -20, -20}, {20, 20, 20});

/// Maps the world point p to m[k] p + offset[k] on object k.
NodeMap affineNodes(const std::vector<Mat3d>& m, const std::vector<Vec3d>& offset) {
  NodeMap nodes;
  nodes.step = 4, nodes.objects = m.size();
  nodes.origin = openvdb::Coord(-7), nodes.size = openvdb::Coord(15);
  nodes.known.assign(size_t(15 * 15 * 15), 1);
  nodes.at.resize(nodes.known.size() * m.size());
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-7), openvdb::Coord(7)).begin(); c; ++c)
    for (size_t k = 0; k < m.size(); ++k)
      nodes.at[nodes.index((*c)[0], (*c)[1], (*c)[2]) * m.size() + k] =
          openvdb::Vec3s(m[k] * (4 * kWarpVoxel * (*c).asVec3d()) + offset[k]);
  return nodes;
}

template <typename GridType, typename Function>
typename GridType::Ptr filled(const Function& f, const openvdb::CoordBBox& box = kWarpBox) {
  auto grid = GridType::create();
  grid->setTransform(Transform::createLinearTransform(kWarpVoxel));
  for (auto c = box.begin(); c; ++c) grid->tree().setValue(*c, f(grid->indexToWorld(*c)));
  return grid;
}

CarriedGrid carried(const openvdb::GridBase::ConstPtr& grid, size_t shape, double weight) {
  CarriedGrid c;
  c.grid = grid, c.shape = c.object = shape, c.weight = weight;
  return c;
}

openvdb::GridBase::Ptr warped(const std::vector<CarriedGrid>& grids, const NodeMap& nodes,
                              bool conserve = false) {
  Weights weights(nodes.objects, 0);
  for (const CarriedGrid& g : grids) weights[g.object] = g.weight;
  return warpGrids(grids, nodes, LocalWeights(weights, nullptr),
                   *Transform::createLinearTransform(kWarpVoxel), conserve);
}

const Mat3d kStill = Mat3d::identity(), kTurn = rotationFromVector({0, 0, M_PI / 2});

double parabola(const Vec3d& p) { return 5 + p[0] - 2 * p[1] + p[2] * p[2]; }

/// sum_k w_k g_k(M_k(p)); Catmull-Rom splines reproduce parabolas between voxels where clamping to the range
/// of neighbours allows it.
TEST(WarpGrid, ValuesAreTheWeightedSumOfTheirs) {
  const auto a = filled<FloatGrid>([](const Vec3d& p) { return float(parabola(p)); });
  const auto b = filled<FloatGrid>([](const Vec3d& p) { return float(3 - p[1] + 0.5 * p[0]); });
  const Vec3d shift(0.23, -0.11, 0.07);
  const NodeMap nodes = affineNodes({kStill, kTurn}, {shift, -shift});
  const auto result =
      openvdb::gridPtrCast<FloatGrid>(warped({carried(a, 0, 0.3), carried(b, 1, 0.7)}, nodes));
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-14), openvdb::Coord(14)).begin(); c; ++c) {
    const Vec3d p = kWarpVoxel * (*c).asVec3d(), q = kTurn * p - shift;
    const double wanted = 0.3 * parabola(p + shift) + 0.7 * (3 - q[1] + 0.5 * q[0]);
    // At the parabola's vertex the clamping cuts off at most h^2 / 4.
    ASSERT_NEAR(result->tree().getValue(*c), wanted, 0.3 * kWarpVoxel * kWarpVoxel / 4 + 1e-4) << *c;
    ASSERT_TRUE(result->tree().isValueOn(*c)) << *c;
  }
}

/// What the weights lack to a sum of 1 is filled with background, and inactive regions stay inactive.
TEST(WarpGrid, MissingWeightIsBackground) {
  auto a = filled<FloatGrid>([](const Vec3d&) { return 2.f; }, {{-4, -4, -4}, {4, 4, 4}});
  openvdb::tools::changeBackground(a->tree(), 0.5f);
  const auto result =
      openvdb::gridPtrCast<FloatGrid>(warped({carried(a, 0, 0.25)}, affineNodes({kStill}, {{0, 0, 0}})));
  EXPECT_NEAR(result->tree().getValue({0, 0, 0}), 0.25 * 2 + 0.75 * 0.5, 1e-6);
  EXPECT_NEAR(result->background(), 0.5, 1e-6);
  EXPECT_FALSE(result->tree().isValueOn({12, 0, 0}));
  EXPECT_NEAR(result->tree().getValue({12, 0, 0}), 0.5, 1e-6);
}

/// Conserved densities are divided by the map's change of volume, here 8.
TEST(WarpGrid, ConservedDensitiesThinOut) {
  const auto a = filled<FloatGrid>([](const Vec3d&) { return 1.f; });
  const NodeMap nodes = affineNodes({kStill * 0.5}, {{0, 0, 0}});  // the in-between is twice as large
  const auto kept = openvdb::gridPtrCast<FloatGrid>(warped({carried(a, 0, 1)}, nodes, true));
  EXPECT_NEAR(kept->tree().getValue({3, 2, 1}), 1 / 8.0, 1e-5);
  EXPECT_NEAR(openvdb::gridPtrCast<FloatGrid>(warped({carried(a, 0, 1)}, nodes))->tree().getValue({3, 2, 1}),
              1, 1e-5);
}

/// Vectors are turned back by the map; colours and texture coordinates, recognised by name, are not.
TEST(WarpGrid, VectorsTurnButColoursDoNot) {
  const NodeMap nodes = affineNodes({kTurn}, {{0, 0, 0}});
  for (const char* name : {"v", "Cd", "uv"}) {
    auto a = filled<openvdb::Vec3SGrid>([](const Vec3d&) { return openvdb::Vec3s(1, 0, 0); });
    a->setName(name);
    const auto result = openvdb::gridPtrCast<openvdb::Vec3SGrid>(warped({carried(a, 0, 1)}, nodes));
    const Vec3d wanted = name == std::string("v") ? kTurn.transpose() * Vec3d(1, 0, 0) : Vec3d(1, 0, 0);
    EXPECT_LE((Vec3d(result->tree().getValue({2, 3, 4})) - wanted).length(), 1e-5) << name;
  }
}

/// Integers are labels: the nearest voxel's value is taken.
TEST(WarpGrid, LabelsAreTheNearestVoxels) {
  const auto label = [](const Vec3d& p) {
    return int(std::lround(p[0] / kWarpVoxel)) + 100 * int(std::lround(p[1] / kWarpVoxel));
  };
  const auto a = filled<openvdb::Int32Grid>(label);
  const Vec3d shift(0.137, 0.084, 0);
  const auto result =
      openvdb::gridPtrCast<openvdb::Int32Grid>(warped({carried(a, 0, 1)}, affineNodes({kStill}, {shift})));
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-10), openvdb::Coord(10)).begin(); c; ++c)
    ASSERT_EQ(result->tree().getValue(*c), label(kWarpVoxel * (*c).asVec3d() + shift)) << *c;
  EXPECT_THROW(
      warped({carried(a, 0, 0.5), carried(a, 1, 0.5)}, affineNodes({kStill, kStill}, {shift, shift})),
      InputError);
}

TEST(WarpGrid, TypesMustAgree) {
  const auto a = filled<FloatGrid>([](const Vec3d&) { return 1.f; }, {{0, 0, 0}, {1, 1, 1}});
  const auto b = filled<openvdb::DoubleGrid>([](const Vec3d&) { return 1.0; }, {{0, 0, 0}, {1, 1, 1}});
  EXPECT_THROW(warped({carried(a, 0, 0.5), carried(b, 1, 0.5)},
                      affineNodes({kStill, kStill}, {Vec3d(0.0), Vec3d(0.0)})),
               InputError);
}

TEST(WarpGrid, KnowsWhatItCanCarry) {
  EXPECT_TRUE(canCarry(*FloatGrid::create()) && isBlended(*FloatGrid::create()));
  EXPECT_TRUE(canCarry(*openvdb::Vec3DGrid::create()) && isBlended(*openvdb::Vec3DGrid::create()));
  EXPECT_TRUE(canCarry(*openvdb::MaskGrid::create()) && !isBlended(*openvdb::MaskGrid::create()));
  EXPECT_TRUE(canCarry(*openvdb::Vec3IGrid::create()) && !isBlended(*openvdb::Vec3IGrid::create()));
}

/// A common transform up to a shift is kept; otherwise the world's axes and the mean voxel size are used.
TEST(WarpGrid, TransformsAreSharedWhereAxesAgree) {
  const auto a = FloatGrid::create(), b = FloatGrid::create();
  a->setTransform(Transform::createLinearTransform(0.2));
  auto moved = Transform::createLinearTransform(0.2);
  moved->postTranslate({0.05, 7, 0});
  b->setTransform(moved);
  EXPECT_EQ(*commonTransform({carried(a, 0, 0.5), carried(b, 1, 0.5)}), a->transform());
  auto turned = Transform::createLinearTransform(0.4);
  turned->postRotate(0.3, openvdb::math::Z_AXIS);
  b->setTransform(turned);
  const auto common = commonTransform({carried(a, 0, 0.75), carried(b, 1, 0.25)});
  EXPECT_NEAR(common->voxelSize()[0], 0.25, 1e-12);
  EXPECT_LE(
      (common->indexToWorld(Vec3d(1, 0, 0)) - common->indexToWorld(Vec3d(0.0)) - Vec3d(0.25, 0, 0)).length(),
      1e-12);
}

/// One object that does not move: its box is its own, one voxel wider, and the nodes are located
/// at its voxels.
TEST(WarpGrid, AStillObjectKeepsItsBox) {
  const auto a = filled<FloatGrid>([](const Vec3d&) { return 1.f; }, {{-3, 2, 5}, {7, 9, 11}});
  Carrying still;
  still.anchor = {0.5, 0, 0};
  const openvdb::CoordBBox box = boxOf({carried(a, 0, 1)}, still, a->transform());
  // Rounding may add a voxel.
  EXPECT_TRUE(box.isInside(openvdb::CoordBBox({-4, 1, 4}, {8, 10, 12}))) << box;
  EXPECT_TRUE(openvdb::CoordBBox({-5, 0, 3}, {9, 11, 13}).isInside(box)) << box;
  EXPECT_TRUE(boxOf({carried(FloatGrid::create(), 0, 1)}, still, a->transform()).empty());
  const NodeMap nodes = carryingNodes(box, still, a->transform(), 4);
  for (int i : {-1, 0, 1, 2}) {
    const Vec3d position = Vec3d(nodes.at[nodes.index(i, 1, 2)]) + still.anchor;
    EXPECT_LE((position - kWarpVoxel * 4 * Vec3d(i, 1, 2)).length(), 1e-6);
  }
}

TEST(WarpGrid, LargeBoxesHaveCoarserNodes) {
  EXPECT_EQ(carryingStep({{0, 0, 0}, {399, 10, 10}}), 4);
  EXPECT_EQ(carryingStep({{0, 0, 0}, {10, 400, 10}}), 8);
}

}  // namespace
}  // namespace slicemorph

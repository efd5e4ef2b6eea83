#include "engine/volume/faint_values.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

template <typename Grid>
void expectFaintLeftOut() {
  using Value = typename Grid::ValueType;
  const auto grid = Grid::create(Value(0));
  const openvdb::Coord zero(0, 0, 0), faint(1, 0, 0), negative(2, 0, 0), strong(3, 0, 0), off(4, 0, 0);
  auto& tree = grid->tree();
  tree.setValueOn(zero, Value(0)), tree.setValueOn(faint, Value(0.01)),
      tree.setValueOn(negative, Value(-0.5));
  tree.setValueOn(strong, Value(0.25)), tree.setValueOff(off, Value(1e-4));
  tree.fill(openvdb::CoordBBox({128, 0, 0}, {255, 127, 127}), Value(0.02), true);
  tree.fill(openvdb::CoordBBox({256, 0, 0}, {383, 127, 127}), Value(3), true);
  EXPECT_EQ(faintestValue(*grid), double(Value(0.01)));
  dropFainter(*grid, 0.25);
  EXPECT_EQ(grid->activeVoxelCount(), 2u + 128u * 128u * 128u);
  EXPECT_FALSE(tree.isValueOn(zero) || tree.isValueOn(faint) || tree.isValueOn({200, 5, 5}));
  EXPECT_EQ(tree.getValue(faint), Value(0));
  EXPECT_EQ(tree.getValue({200, 5, 5}), Value(0));
  EXPECT_EQ(tree.getValue(negative), Value(-0.5));
  EXPECT_TRUE(tree.isValueOn(strong)) << "the least value itself stays";
  EXPECT_TRUE(tree.isValueOn({300, 5, 5}));
}

TEST(FaintValues, AreLeftOutOfFloatsAndDoubles) {
  expectFaintLeftOut<FloatGrid>();
  expectFaintLeftOut<openvdb::DoubleGrid>();
}

TEST(FaintValues, NothingIsTheFaintestOfNothing) {
  EXPECT_TRUE(std::isinf(faintestValue(*FloatGrid::create(0.f))));
  EXPECT_TRUE(std::isinf(faintestValue(*openvdb::BoolGrid::create(false))));
  const auto zeros = FloatGrid::create(0.f);
  zeros->tree().setValueOn({0, 0, 0}, 0.f);
  EXPECT_TRUE(std::isinf(faintestValue(*zeros)));
  dropFainter(*zeros, 0);
  EXPECT_EQ(zeros->activeVoxelCount(), 0u);
}

}  // namespace
}  // namespace slicemorph

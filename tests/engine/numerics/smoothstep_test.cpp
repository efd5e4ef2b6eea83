#include "engine/numerics/smoothstep.h"

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

TEST(Smoothstep, IsClampedBeyondItsEnds) {
  EXPECT_EQ(smoothstep(-3, 0.5, 2), 0);
  EXPECT_EQ(smoothstep(0.5, 0.5, 2), 0);
  EXPECT_EQ(smoothstep(2, 0.5, 2), 1);
  EXPECT_EQ(smoothstep(17, 0.5, 2), 1);
}

/// The cubic with the values 0 and 1 and no slope at its ends: 3 x^2 - 2 x^3, odd about its middle.
TEST(Smoothstep, IsTheHermiteCubic) {
  constexpr int kSteps = 32;
  double before = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = double(i) / kSteps, value = smoothstep(0.5 + 1.5 * x, 0.5, 2);
    EXPECT_NEAR(value, 3 * x * x - 2 * x * x * x, 1e-15);
    EXPECT_NEAR(value + smoothstep(2 - 1.5 * x, 0.5, 2), 1, 1e-15);
    EXPECT_GE(value, before);
    before = value;
  }
}

}  // namespace
}  // namespace slicemorph

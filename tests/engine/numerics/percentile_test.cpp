#include "engine/numerics/percentile.h"

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

/// Of 0, 10, 20, ..., 100 in any order: a share s of the way from the first to the last is 100 s.
TEST(Percentile, IsLinearBetweenNeighbours) {
  std::vector<float> values;
  for (int i = 0; i <= 10; ++i) values.push_back(float(10 * (7 * i % 11)));
  for (const double share : {0.0, 0.05, 0.5, 0.51, 0.95, 0.99, 1.0}) {
    std::vector<float> again = values;
    EXPECT_NEAR(percentileOf(again, share), 100 * share, 1e-9) << share;
  }
}

TEST(Percentile, OfOneAndOfEqualValuesIsThem) {
  std::vector<double> one{3.5}, equal{2, 2, 2, 7, 2};
  EXPECT_EQ(percentileOf(one, 0.95), 3.5);
  EXPECT_EQ(percentileOf(equal, 0.5), 2);
  EXPECT_EQ(percentileOf(equal, 1), 7);
}

}  // namespace
}  // namespace slicemorph

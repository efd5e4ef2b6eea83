#include "engine/numerics/catmull_rom.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

/// Value at `a` of the spline through f(-1), f(0), f(1), f(2).
template <typename Function>
double splined(const Function& f, double a) {
  const std::array<double, 4> w = catmullRomWeights(a);
  return w[0] * f(-1) + w[1] * f(0) + w[2] * f(1) + w[3] * f(2);
}

/// Reference: the cubic through nodes 0 and 1 whose slopes there are those of the chords
/// between their neighbours.
template <typename Function>
double hermite(const Function& f, double a) {
  const double m0 = 0.5 * (f(1) - f(-1)), m1 = 0.5 * (f(2) - f(0)), b = a * a, c = b * a;
  return (2 * c - 3 * b + 1) * f(0) + (c - 2 * b + a) * m0 + (3 * b - 2 * c) * f(1) + (c - b) * m1;
}

TEST(CatmullRom, IsTheHermiteCubicOfItsNodes) {
  const auto f = [](double x) { return std::sin(1.7 * x + 0.3) + x * x * x; };
  for (double a : {0.0, 0.125, 0.4, 0.5, 0.77, 1.0}) EXPECT_NEAR(splined(f, a), hermite(f, a), 1e-14) << a;
}

/// A parabola's chords have its slopes, so it is reproduced exactly; weights sum to 1.
TEST(CatmullRom, MeetsParabolas) {
  for (double a = 0; a <= 1; a += 0.0625) {
    EXPECT_NEAR(splined([](double) { return 1.0; }, a), 1, 1e-15);
    EXPECT_NEAR(splined([](double x) { return 3 - 2 * x + 5 * x * x; }, a), 3 - 2 * a + 5 * a * a, 1e-14);
  }
}

}  // namespace
}  // namespace slicemorph

// Inner distances and the turns they suggest.
#include "engine/frame/inner_samples.h"

#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

using shapes::capsule;
using shapes::joined;

const openvdb::BBoxd kBox(Vec3d(-1.8), Vec3d(1.8));

/// In a straight rod inner distances are the straight ones, but for steps of the grid's 26 directions, which add 8 %
/// at most; weights sum to 1; distances are symmetric and of mean square 1.
TEST(InnerSamples, OfARod) {
  const InnerSamples s = innerSamples(*shapes::fieldOf(capsule({-1, 0.2, 0}, {1, 0.2, 0}, 0.15), kBox, 0.03));
  ASSERT_GE(s.position.size(), 20u);
  double weights = 0, squares = 0, unit = 0;
  for (double w : s.weight) weights += w;
  EXPECT_NEAR(weights, 1, 1e-12);
  for (size_t i = 0; i < s.position.size(); ++i)
    for (size_t j = 0; j < s.position.size(); ++j) {
      EXPECT_EQ(s.distance[i][j], s.distance[j][i]);
      squares += s.weight[i] * s.weight[j] * s.distance[i][j] * s.distance[i][j];
      unit += s.weight[i] * s.weight[j] * (s.position[i] - s.position[j]).lengthSqr();
    }
  EXPECT_NEAR(squares, 1, 1e-9);
  for (size_t i = 0; i < s.position.size(); ++i)
    for (size_t j = 0; j < s.position.size(); ++j) {
      const double straight = (s.position[i] - s.position[j]).length() / std::sqrt(unit);
      EXPECT_LE(std::abs(s.distance[i][j] - straight), 0.09 * straight + 0.05);
    }
}

/// A ring that is cut open: its ends lie side by side and are a whole way round apart.
TEST(InnerSamples, GoRoundGaps) {
  std::vector<shapes::Distance> parts;
  const auto at = [](int i) { return Vec3d(std::cos(i * 0.2), std::sin(i * 0.2), 0); };
  for (int i = 0; i < 29; ++i) parts.push_back(capsule(at(i), at(i + 1), 0.12));
  const InnerSamples s = innerSamples(*shapes::fieldOf(joined(parts), kBox, 0.03));
  double widest = 0, apart = 0;
  for (size_t i = 0; i < s.position.size(); ++i)
    for (size_t j = 0; j < s.position.size(); ++j)
      if (s.distance[i][j] > widest)
        widest = s.distance[i][j], apart = (s.position[i] - s.position[j]).length();
  double farthest = 0;
  for (const Vec3d& p : s.position)
    for (const Vec3d& q : s.position) farthest = std::max(farthest, (p - q).length());
  EXPECT_LT(apart, 0.5 * farthest);
}

/// An animal against one that looks the other way: turned round it fits far better, though overlap hardly tells.
TEST(InnerDistortion, TellsHeadsFromTails) {
  const auto animal = [](double ahead) {
    const auto at = [&](double x, double y, double z) { return Vec3d(ahead * x, y, ahead * z); };
    return joined({capsule(at(-0.8, 0, 0), at(0.8, 0, 0), 0.3),
                   capsule(at(0.8, 0.1, 0), at(1.2, 0.4, 0), 0.22),
                   capsule(at(-0.8, 0.1, 0), at(-1.4, 0.5, 0), 0.07)});
  };
  const InnerSamples a = innerSamples(*shapes::fieldOf(animal(1), kBox, 0.03)),
                     b = innerSamples(*shapes::fieldOf(animal(-1), kBox, 0.03));
  const Mat3d round = rotationFromVector({0, M_PI, 0});
  std::printf("  turned round %.4f, as it is %.4f\n", innerDistortion(a, b, round),
              innerDistortion(a, b, Mat3d::identity()));
  EXPECT_LT(innerDistortion(a, b, round), 0.8 * innerDistortion(a, b, Mat3d::identity()));
  // Sums in another order differ by rounding alone.
  EXPECT_NEAR(innerDistortion(a, b, round), innerDistortion(b, a, round.transpose()), 1e-12);
}

}  // namespace
}  // namespace slicemorph

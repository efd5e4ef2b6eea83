#include "engine/numerics/distance_transform.h"

#include "engine/numerics/lower_envelope.h"
#include "engine/numerics/mask_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

using openvdb::Coord;

TEST(LowerEnvelope, FindsTheLowestParabola) {
  std::mt19937 random(5);
  for (int sample = 0; sample < 50; ++sample) {
    const int n = 1 + int(random() % 30);
    const double unit = 0.1 + double(random() % 100) / 20;
    LowerEnvelope<double> envelope(n, unit);
    envelope.clear();
    std::vector<std::pair<int, double>> parabolas;
    for (int x = 0; x < n; ++x)
      if (random() % 3) parabolas.emplace_back(x, double(random() % 1000) / 7);
    for (const auto& [apex, height] : parabolas) envelope.add(apex, height);
    ASSERT_EQ(envelope.empty(), parabolas.empty());
    for (int x = 0; x < n && !parabolas.empty(); ++x) {
      double lowest = 1e300;
      for (const auto& [apex, height] : parabolas)
        lowest = std::min(lowest, height + unit * (x - apex) * (x - apex));
      const int found = envelope.nearest(x);
      for (const auto& [apex, height] : parabolas)
        if (apex == found) EXPECT_NEAR(height + unit * (x - apex) * (x - apex), lowest, 1e-9);
    }
  }
}

TEST(SignedDistances, AreThoseOfBruteForce) {
  std::mt19937 random(9);
  for (int sample = 0; sample < 12; ++sample) {
    const Coord size(1 + int(random() % 9), 1 + int(random() % 9), 2 + int(random() % 9));
    const Vec3d spacing(0.5 + random() % 5, 0.25 + random() % 3, 1 + random() % 2);
    std::vector<char> inside(size_t(size[0]) * size[1] * size[2]);
    const int rarity = 1 + int(random() % 20);
    for (char& v : inside) v = random() % rarity == 0;
    inside.front() = 1, inside.back() = 0;
    const auto at = [&](size_t n) {
      return spacing *
             Vec3d(double(n % size[0]), double(n / size[0] % size[1]), double(n / size[0] / size[1]));
    };
    const std::vector<float> found = signedDistances(inside, size, spacing);
    for (size_t i = 0; i < inside.size(); ++i) {
      double nearest = 1e300;
      for (size_t j = 0; j < inside.size(); ++j)
        if (inside[i] != inside[j]) nearest = std::min(nearest, (at(i) - at(j)).length());
      // Squares are three sums of single precision, each off by 6e-8 at most.
      EXPECT_NEAR(found[i], inside[i] ? nearest : -nearest, 1e-6 * nearest) << i;
    }
  }
}

TEST(MaskDistance, IsThatOfBruteForce) {
  std::mt19937 random(13);
  for (int sample = 0; sample < 20; ++sample) {
    const PixelBox box{-3, 4, -3 + 1 + int(random() % 20), 4 + 1 + int(random() % 20)};
    const float stepX = 0.5f + float(random() % 4), stepY = 0.25f + float(random() % 3), far = 1234;
    std::vector<std::uint8_t> mask(box.count());
    const int rarity = 1 + int(random() % 20);
    for (std::uint8_t& v : mask) v = random() % rarity == 0;
    const std::vector<float> found = maskDistance(mask, box, stepX, stepY, far);
    const double step = std::min(stepX, stepY), longest = 20 * std::max(stepX, stepY);
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x) {
        const bool own = mask[box.index(x, y)];
        double nearest = 1e300;
        for (int v = box.y0; v < box.y1; ++v)
          for (int u = box.x0; u < box.x1; ++u)
            if (bool(mask[box.index(u, v)]) != own)
              nearest = std::min(nearest, std::hypot((u - x) * double(stepX), (v - y) * double(stepY)));
        const double expected = nearest > 1e299 ? far : nearest - 0.5 * step;
        // Where two are about as near, single precision may take the other one: squares are known to 1.2e-7 of the
        // image's, so that distances, a step or more, are off by half of that over the distance.
        EXPECT_NEAR(found[box.index(x, y)], own ? expected : -expected, 1.2e-7 * longest * longest / step);
      }
  }
}

}  // namespace
}  // namespace slicemorph

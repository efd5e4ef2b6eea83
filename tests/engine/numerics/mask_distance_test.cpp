#include "engine/numerics/mask_distance.h"

#include "engine/numerics/lower_envelope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

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
      for (const auto& [apex, height] : parabolas) {
        if (apex != found) continue;
        EXPECT_NEAR(height + unit * (x - apex) * (x - apex), lowest, 1e-9);
      }
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
        // Where two pixels are nearly equidistant, single precision may choose the other one: squares are
        // exact to 1.2e-7 of the image's, so distances, which are a step or more, may differ by half of that
        // over the distance.
        EXPECT_NEAR(found[box.index(x, y)], own ? expected : -expected, 1.2e-7 * longest * longest / step);
      }
  }
}

}  // namespace
}  // namespace slicemorph

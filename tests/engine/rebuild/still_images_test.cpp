// Images that do not move: equal ones are themselves to the bit, others their weighted mean.
#include "engine/rebuild/still_images.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

template <typename T>
Image stillImage(std::vector<T> values) {
  Image image;
  image.lattice.size = openvdb::Coord(int(values.size()), 1, 1);
  image.values = std::move(values);
  return image;
}

CarriedImage still(const Image& image, double weight) {
  CarriedImage c;
  c.image = &image, c.weight = weight;
  return c;
}

/// Thirds do not sum to 1 and do not divide values exactly; infinite values and such as are none stay.
TEST(StillImages, EqualOnesAreThemselvesToTheBit) {
  const double huge = std::numeric_limits<double>::max(), infinite = std::numeric_limits<double>::infinity();
  const Image a = stillImage<double>(
      {0.1, -1.0 / 3, huge, infinite, -infinite, std::numeric_limits<double>::quiet_NaN(), 0});
  const double third = 1.0 / 3;
  const Image result = blendStill({still(a, third), still(a, third), still(a, third)}, a.lattice);
  const auto &own = std::get<std::vector<double>>(a.values),
             &got = std::get<std::vector<double>>(result.values);
  for (size_t i = 0; i < own.size(); ++i)
    EXPECT_TRUE(got[i] == own[i] || (std::isnan(got[i]) && std::isnan(own[i]))) << own[i] << ' ' << got[i];
}

TEST(StillImages, OthersAreTheirMean) {
  const Image a = stillImage<std::int16_t>({0, 10, -1000}), b = stillImage<std::int16_t>({8, 20, 1000});
  const auto got =
      std::get<std::vector<std::int16_t>>(blendStill({still(a, 0.25), still(b, 0.75)}, a.lattice).values);
  EXPECT_EQ(got, (std::vector<std::int16_t>{6, 18, 500}));  // 17.5 is rounded up
}

/// On another lattice they are interpolated before they are rounded.
TEST(StillImages, BetweenVoxelsTheyAreInterpolated) {
  const Image a = stillImage<std::uint8_t>({0, 3}), b = stillImage<std::uint8_t>({0, 0});
  ImageLattice on = a.lattice;
  on.origin = Vec3d(0.5, 0, 0), on.size[0] = 1;
  const auto got = std::get<std::vector<std::uint8_t>>(blendStill({still(a, 0.9), still(b, 0.1)}, on).values);
  EXPECT_EQ(got[0], 1);  // 1.35; of 2 it would be 1.8
}

TEST(StillImages, SameAreTheSameValuesAtTheSamePlaces) {
  const Image a = stillImage<std::int16_t>({1, 2, 3}), f = stillImage<float>({1, 2, 3});
  Image moved = a, other = stillImage<float>({1, 2, 3.5f});
  const auto same = [&](const Image& b, double iso = 1.5) {
    std::vector<CarriedImage> images{still(a, 0.5), still(b, 0.5)};
    images[0].iso = 1.5, images[1].iso = iso;
    return allSame(images);
  };
  EXPECT_TRUE(same(f));
  EXPECT_FALSE(same(other));
  EXPECT_FALSE(same(f, 2.5));
  moved.lattice.origin[1] += 1e-6;
  EXPECT_TRUE(same(moved));
  moved.lattice.origin[1] += 1e-3;
  EXPECT_FALSE(same(moved));
  EXPECT_FALSE(allSame({still(a, 0.5), still(a, 0.5)}));  // whether they are of one shape is not known
}

}  // namespace
}  // namespace slicemorph

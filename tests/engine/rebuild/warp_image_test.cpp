// Dense images carried by known maps: linear ones are reproduced exactly.
#include "engine/rebuild/warp_image.h"
#include "tests/support/fields.h"
#include "tests/support/shifted_nodes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace slicemorph {
namespace {

ImageLattice latticeOf(const openvdb::Coord& size, const Vec3d& origin, double spacing) {
  ImageLattice lattice{size, origin};
  for (int d = 0; d < 3; ++d) lattice.step[d] = Vec3d(0.0), lattice.step[d][d] = spacing;
  return lattice;
}

template <typename T>
Image imageOf(const ImageLattice& lattice, const std::function<double(const Vec3d&)>& f) {
  std::vector<T> values;
  for (int k = 0; k < lattice.size[2]; ++k)
    for (int j = 0; j < lattice.size[1]; ++j)
      for (int i = 0; i < lattice.size[0]; ++i) values.push_back(T(f(lattice.toWorld(Vec3d(i, j, k)))));
  return {lattice, values};
}

CarriedImage carried(const Image& image, size_t shape, double weight) {
  CarriedImage c;
  c.image = &image, c.shape = shape, c.weight = weight;
  return c;
}

double linear(const Vec3d& p) { return 100 + 7 * p[0] - 3 * p[1] + 2 * p[2]; }

TEST(WarpImage, ValuesAreTheWeightedSumOfTheirs) {
  const ImageLattice large = latticeOf({40, 36, 30}, {-2, -2, -2}, 0.25),
                     on = latticeOf({13, 11, 9}, {0, 0, 0}, 0.4);
  const Image a = imageOf<float>(large, linear),
              b = imageOf<float>(large, [](const Vec3d&p) { return 20 - linear(p) / 2; });
  const Vec3d shift(0.31, -0.2, 0.17);
  const Image result =
      warpImages({carried(a, 0, 0.4), carried(b, 1, 0.6)}, shiftedNodes(on, {shift, -shift}), on);
  const auto& values = std::get<std::vector<float>>(result.values);
  for (int k = 0; k < on.size[2]; ++k)
    for (int j = 0; j < on.size[1]; ++j)
      for (int i = 0; i < on.size[0]; ++i) {
        const Vec3d p = on.toWorld(Vec3d(i, j, k));
        ASSERT_NEAR(values[on.index(i, j, k)], 0.4 * linear(p + shift) + 0.6 * (20 - linear(p - shift) / 2),
                    1e-3);
      }
}

/// More than half a voxel beyond an image its lowest value is used.
TEST(WarpImage, BeyondAnImageIsItsLowestValue) {
  const ImageLattice small = latticeOf({4, 4, 4}, {0, 0, 0}, 1), on = latticeOf({12, 5, 5}, {-4, 0, 0}, 1);
  const Image a = imageOf<float>(small, linear);
  const auto values =
      std::get<std::vector<float>>(warpImages({carried(a, 0, 1)}, shiftedNodes(on, {Vec3d(0.0)}), on).values);
  for (int i = 0; i < 12; ++i) {
    const double x = i - 4;
    EXPECT_NEAR(values[on.index(i, 1, 1)], x < -0.5 || x > 3.5 ? linear({0, 3, 0}) : linear({x, 1, 1}), 1e-4)
        << i;
  }
}

template <typename A, typename B>
size_t typeOf() {
  const ImageLattice on = latticeOf({3, 3, 3}, {0, 0, 0}, 1);
  const Image a = imageOf<A>(on, [](const Vec3d&) { return 1; }),
              b = imageOf<B>(on, [](const Vec3d&) { return 2; });
  const Image result =
      warpImages({carried(a, 0, 0.3), carried(b, 1, 0.7)}, shiftedNodes(on, {Vec3d(0.0), Vec3d(0.0)}), on);
  std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        // 1.7, and of whole numbers the nearest.
        EXPECT_NEAR(double(values[13]), std::is_integral_v<T> ? 2 : 1.7, 1e-6);
      },
      result.values);
  return result.values.index();
}

/// The images' own number type if they share it, else the smallest that holds both.
TEST(WarpImage, NumberTypesHoldBoth) {
  const auto index = [](const ImageValues& v) { return v.index(); };
  const size_t u8 = index(std::vector<std::uint8_t>()), s16 = index(std::vector<std::int16_t>()),
               u16 = index(std::vector<std::uint16_t>()), s32 = index(std::vector<std::int32_t>()),
               f32 = index(std::vector<float>()), f64 = index(std::vector<double>());
  EXPECT_EQ((typeOf<std::uint8_t, std::uint8_t>()), u8);
  EXPECT_EQ((typeOf<std::uint8_t, std::int16_t>()), s16);
  EXPECT_EQ((typeOf<std::uint8_t, std::uint16_t>()), u16);
  EXPECT_EQ((typeOf<std::int16_t, std::uint16_t>()), s32);
  EXPECT_EQ((typeOf<std::int16_t, float>()), f32);
  EXPECT_EQ((typeOf<std::int32_t, float>()), f64);
  EXPECT_EQ((typeOf<double, float>()), f64);
}

/// Balls of radius 1 and 1.2 with values of 1000 inside and 0 outside: half way it is a ball of radius 1.1,
/// without a ghost of either on the two sides of its surface.
TEST(WarpImage, SurfacesAreOfLikeDepth) {
  constexpr double kSpacing = 0.08;
  const ImageLattice on = latticeOf({37, 37, 37}, {-1.44, -1.44, -1.44}, kSpacing);
  std::vector<Image> balls;
  Fields fields;
  for (double radius : {1.0, 1.2}) {
    balls.push_back(imageOf<float>(on, [&](const Vec3d& p) {
      return 1000 * std::min(std::max(0.5 - (p.length() - radius) / kSpacing, 0.0), 1.0);
    }));
    fields.push_back(
        shapes::fieldOf(shapes::sphere({0, 0, 0}, radius), shapes::cube({0, 0, 0}, 1.4), kSpacing));
  }
  std::vector<CarriedImage> images;
  std::vector<Vec3d> shifts;
  for (size_t k = 0; k < 2; ++k) {
    images.push_back(carried(balls[k], k, 0.5));
    images[k].field = fields[k].get(), images[k].anchor = fields[k]->anchor(), images[k].iso = 500;
    shifts.push_back(-fields[k]->anchor());
  }
  const auto values = std::get<std::vector<float>>(warpImages(images, shiftedNodes(on, shifts), on).values);
  for (int k = 0; k < on.size[2]; ++k)
    for (int j = 0; j < on.size[1]; ++j)
      for (int i = 0; i < on.size[0]; ++i) {
        const double r = on.toWorld(Vec3d(i, j, k)).length(), value = values[on.index(i, j, k)];
        // The edge is a voxel wide and interpolated, so its position is known to a fraction of a voxel.
        if (r < 1.1 - 1.5 * kSpacing) {
          ASSERT_GT(value, 900) << r;
        }
        if (r > 1.1 + 1.5 * kSpacing) {
          ASSERT_LT(value, 100) << r;
        }
        if (std::abs(r - 1.1) > 0.1 * kSpacing) {
          ASSERT_EQ(value > 500, r < 1.1) << r;
        }
      }
}

/// Balls whose skin, 1.5 voxels thick, is darker than the isovalue of 500.
struct DarkBalls {
  explicit DarkBalls(const std::vector<double>& radii) {
    for (double radius : radii) {
      balls.push_back(imageOf<float>(on, [&](const Vec3d& p) {
        const double depth = radius - p.length();
        return depth > 1.5 * kSpacing ? 1000 : depth > 0 ? 450 : 0;
      }));
      fields.push_back(
          shapes::fieldOf(shapes::sphere({0, 0, 0}, radius), shapes::cube({0, 0, 0}, 1.4), kSpacing));
    }
    for (size_t k = 0; k < radii.size(); ++k) {
      images.push_back(carried(balls[k], k, 1.0 / double(radii.size())));
      images[k].field = fields[k].get(), images[k].anchor = fields[k]->anchor(), images[k].iso = 500;
      shifts.push_back(-fields[k]->anchor());
    }
  }
  std::vector<float> values() const {
    return std::get<std::vector<float>>(warpImages(images, shiftedNodes(on, shifts), on).values);
  }
  static constexpr double kSpacing = 0.08;
  const ImageLattice on = latticeOf({37, 37, 37}, {-1.44, -1.44, -1.44}, kSpacing);
  std::vector<Image> balls;
  Fields fields;
  std::vector<CarriedImage> images;
  std::vector<Vec3d> shifts;
};

/// A skin darker than the isovalue opens no hole where depths of different shapes are matched: values stay above it
/// inside the in-between, a ball of radius 1.1, and below it outside.
TEST(WarpImage, TheSurfaceStaysWhereTheShapeHasIt) {
  const DarkBalls dark({1.0, 1.2});
  const std::vector<float> values = dark.values();
  for (int k = 0; k < dark.on.size[2]; ++k)
    for (int j = 0; j < dark.on.size[1]; ++j)
      for (int i = 0; i < dark.on.size[0]; ++i) {
        const double r = dark.on.toWorld(Vec3d(i, j, k)).length(), value = values[dark.on.index(i, j, k)];
        if (std::abs(r - 1.1) > 0.1 * DarkBalls::kSpacing) {
          ASSERT_EQ(value > 500, r < 1.1) << r;
        }
      }
}

/// Where shapes lie on each other nothing is changed: a dark skin is what the images have there.
TEST(WarpImage, WhatLiesOnItselfKeepsItsValues) {
  const DarkBalls dark({1.0, 1.0});
  const std::vector<float> values = dark.values();
  const auto& own = std::get<std::vector<float>>(dark.balls[0].values);
  // Positions are in single precision: to 1e-5 of a voxel, over which the values change by up to 1000.
  for (size_t i = 0; i < own.size(); ++i) ASSERT_NEAR(values[i], own[i], 0.05) << i;
}

/// As the second weight goes to 0, so does what is not the first image: the surfaces are 2.5 voxels apart.
TEST(WarpImage, TheFirstImageIsReachedSmoothly) {
  DarkBalls dark({1.0, 1.2});
  const auto& first = std::get<std::vector<float>>(dark.balls[0].values);
  const auto& second = std::get<std::vector<float>>(dark.balls[1].values);
  double whole = 0;
  for (size_t i = 0; i < first.size(); ++i) whole += std::pow(first[i] - second[i], 2);
  for (double t : {0.01, 0.001}) {
    dark.images[0].weight = 1 - t, dark.images[1].weight = t;
    const std::vector<float> values = dark.values();
    double sum = 0;
    for (size_t i = 0; i < first.size(); ++i) sum += std::pow(values[i] - first[i], 2);
    // Depths go by t times 2.5 voxels; the edge of a voxel's width and what moves beside it: ten times t is ample.
    EXPECT_LT(std::sqrt(sum / whole), 10 * t) << t;
  }
}

}  // namespace
}  // namespace slicemorph

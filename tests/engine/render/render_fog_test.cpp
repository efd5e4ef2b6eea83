#include "engine/render/render_fog.h"
#include "engine/render/black_body.h"
#include "engine/render/light_field.h"
#include "slicemorph/errors.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

/// A block of fog of constant density: 40 x 40 x 20 voxels, centred on the world's origin.
FloatGrid::Ptr block(float density, const Vec3d& voxel = Vec3d(1.0)) {
  auto transform = openvdb::math::Transform::createLinearTransform(1.0);
  transform->preScale(voxel);
  transform->postTranslate(-voxel * Vec3d(19.5, 19.5, 9.5));
  auto grid = FloatGrid::create(0.0f);
  grid->setTransform(transform);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->fill(openvdb::CoordBBox({0, 0, 0}, {39, 39, 19}), density);
  return grid;
}

Camera frontView(double height) {
  Camera camera;
  camera.position = {0, 0, height};
  camera.orthographicHeight = height;
  return camera;
}

RenderOptions smallPicture() {
  RenderOptions options;
  options.width = options.height = 40;
  options.background = false, options.channels = true;
  return options;
}

size_t middle(const Picture& image) {
  return size_t(image.height / 2) * size_t(image.width) + size_t(image.width / 2);
}

TEST(RenderFog, AbsorbsByBeerAndLambertOnAnyVoxels) {
  for (const Vec3d& voxel : {Vec3d(1.0), Vec3d(0.5, 2, 1), Vec3d(1, 1, 0.25)}) {
    for (const float density : {0.5f, 2.0f}) {
      Fog fog;
      fog.density = block(density, voxel);
      FogLook look;
      look.extinction = 0.05;
      const Picture image = renderFog(fog, look, frontView(40), smallPicture());
      // The ramps at both ends contain as much as the half voxels they replace. With the midpoint rule and
      // steps of a voxel, each of the four kinks costs at most an eighth of a voxel.
      const double depth = look.extinction * density * 20 * voxel.z();
      const double error = look.extinction * density * 0.5 * voxel.z() * std::exp(-depth);
      EXPECT_NEAR(image.mask[middle(image)], 1 - std::exp(-depth), error + 1e-5);
      EXPECT_EQ(image.mask[middle(image)], image.rgba[4 * middle(image) + 3]);
    }
  }
}

TEST(RenderFog, DepthIsWhereTheOpacityLies) {
  Fog fog;
  fog.density = block(1);
  const size_t n = middle(renderFog(fog, {}, frontView(40), smallPicture()));
  for (const double extinction : {0.02, 0.2, 2.0}) {
    FogLook look;
    look.extinction = extinction;
    // Mean of an exponential that is truncated at the back; the front is at z = 10.
    const double t = 20 * extinction, exact = 40 - 10 + (1 / extinction) * (1 - t / std::expm1(t));
    EXPECT_NEAR(renderFog(fog, look, frontView(40), smallPicture()).depth[n], exact, 0.5) << extinction;
  }
  EXPECT_EQ(renderFog(fog, {}, frontView(100), smallPicture()).depth[0], kFarAway);
}

TEST(RenderFog, GlowsAlsoWhereThereIsNoDensity) {
  Fog fog;
  fog.density = FloatGrid::create(0.0f);
  fog.heat = block(0.5f);
  FogLook look;
  look.hottest = 1;
  look.emission = 0.3;
  const Picture image = renderFog(fog, look, frontView(40), smallPicture());
  const Colour exact = blackBody(1100) * float(0.3 * 20 / 16);
  // The ramps glow less than the half voxels they replace: h / 5 against h / 2 at each end.
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(image.rgba[4 * middle(image) + size_t(c)], exact[c], 0.06 * exact[0]) << c;
  EXPECT_EQ(image.mask[middle(image)], 0);
  EXPECT_EQ(image.rgba[0], image.rgba[0]);
}

TEST(RenderFog, LightFallsOffOnItsWayThroughTheFog) {
  const auto density = block(1);
  const double extinction = 0.1;
  const LightField light(*density, {0, 0, 1}, extinction);
  for (const double inside : {0.0, 5.0, 10.0, 15.0}) {
    const double t = extinction * inside;
    const double exact = (std::exp(-t) + 0.5 * std::exp(-t / 2) + 0.25 * std::exp(-t / 4)) / 1.75;
    // Half a node's spacing in depth.
    EXPECT_NEAR(light.at({0, 0, 10 - inside}), exact, 0.75 * extinction);
  }
  EXPECT_GT(light.at({0, 0, 50}), 0.9);
}

TEST(RenderFog, TheSideTowardsTheLightIsBrighter) {
  Fog fog;
  fog.density = block(1);
  FogLook look;
  look.extinction = 0.2;
  RenderOptions options = smallPicture();
  options.light = {-1, 0, 0};
  const Picture image = renderFog(fog, look, frontView(50), options);
  const size_t row = size_t(image.height / 2) * size_t(image.width);
  EXPECT_GT(image.rgba[4 * (row + 34)], 1.5f * image.rgba[4 * (row + 6)]);
}

TEST(RenderFog, TheColourGridColoursIt) {
  Fog fog;
  fog.density = block(1);
  const auto colour = openvdb::Vec3SGrid::create(openvdb::Vec3f(0, 1, 0));
  fog.colour = colour;
  const Picture image = renderFog(fog, {}, frontView(40), smallPicture());
  EXPECT_EQ(image.rgba[4 * middle(image)], 0);
  EXPECT_GT(image.rgba[4 * middle(image) + 1], 0);
}

TEST(RenderFog, SameBytesForAnyThreadCount) {
  Fog fog;
  fog.density = block(0.1f);
  fog.heat = block(0.7f, Vec3d(0.5));
  const FogMeasure measure = measureFog(fog);
  std::vector<Picture> pictures;
  for (const size_t threads : {1, 2, 4})
    withThreads(threads, [&] {
      pictures.push_back(renderFog(fog, lookOf({measure}), frameAll({measure.box}), smallPicture()));
    });
  for (const size_t n : {1, 2}) {
    EXPECT_EQ(pictures[0].rgba, pictures[n].rgba);
    EXPECT_EQ(pictures[0].depth, pictures[n].depth);
  }
}

TEST(RenderFog, TheLookServesTheWholeSequence) {
  Fog fog, nothing;
  fog.density = block(3);
  fog.heat = block(700);
  nothing.density = FloatGrid::create(0.0f);
  const FogMeasure measure = measureFog(fog), none = measureFog(nothing);
  EXPECT_NEAR(measure.density, 3, 1e-6);
  EXPECT_NEAR(measure.thickness, std::cbrt(40.0 * 40 * 20), 1e-6);
  EXPECT_EQ(measure.hottest, 700);
  EXPECT_TRUE(none.box.empty());
  const FogLook look = lookOf({none, measure, none});
  EXPECT_EQ(look.hottest, 700);
  EXPECT_EQ(look.extinction, lookOf({measure}).extinction);
  const Picture image = renderFog(nothing, look, frontView(40), smallPicture());
  EXPECT_EQ(image.mask[middle(image)], 0);
}

TEST(RenderFog, RefusesWhatItCannotDraw) {
  Fog fog;
  const auto density = block(1);
  fog.density = density;
  RenderOptions options;
  options.height = 0;
  EXPECT_THROW(renderFog(fog, {}, frontView(40), options), InputError);
  density->setTransform(
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0.0), Vec3d(40.0)), 0.5, 10, 1));
  EXPECT_THROW(renderFog(fog, {}, frontView(40), smallPicture()), InputError);
  EXPECT_THROW(measureFog(fog), InputError);
}

TEST(BlackBody, HasTheChromaticityOfThePlanckianLocus) {
  // CIE: illuminant A is a black body of 2856 K; the others are from CIE 1931 tables. The observer's fit is
  // accurate to 0.005.
  const double known[][3] = {{2000, 0.5267, 0.4133}, {2856, 0.4476, 0.4074}, {6500, 0.3135, 0.3236}};
  for (const auto& [kelvin, x, y] : known) {
    const Colour c = blackBody(kelvin);
    const double X = 0.4124564 * c[0] + 0.3575761 * c[1] + 0.1804375 * c[2];
    const double Y = 0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2];
    const double Z = 0.0193339 * c[0] + 0.1191920 * c[1] + 0.9503041 * c[2];
    EXPECT_NEAR(X / (X + Y + Z), x, 0.006) << kelvin;
    EXPECT_NEAR(Y / (X + Y + Z), y, 0.006) << kelvin;
    EXPECT_NEAR(Y, 1, 1e-3);
  }
}

}  // namespace
}  // namespace slicemorph

#include "engine/render/render.h"
#include "engine/render/contact_sheet.h"
#include "io/image/png_writer.h"
#include "slicemorph/errors.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <png.h>

#include <cmath>
#include <filesystem>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;

FloatGrid::Ptr sphere(double radius, const Vec3d& centre, double voxelSize) {
  return openvdb::tools::createLevelSetSphere<FloatGrid>(float(radius), openvdb::Vec3f(centre),
                                                         float(voxelSize));
}

double alphaSum(const Picture& image) {
  double sum = 0;
  for (size_t n = 3; n < image.rgba.size(); n += 4) sum += image.rgba[n];
  return sum;
}

/// Looks along -z at `target`.
Camera frontView(const Vec3d& target, double height) {
  Camera camera;
  camera.target = target;
  camera.position = target + Vec3d(0, 0, height);
  camera.orthographicHeight = height;
  return camera;
}

TEST(Render, SilhouetteHasTheAreaOfTheSphereAtAnyScale) {
  for (const double scale : {6e-4, 1.0, 250.0}) {
    const Vec3d centre(31.3 * scale, -17.7 * scale, 55.1 * scale);
    const auto grid = sphere(20 * scale, centre, scale);
    RenderOptions options;
    options.width = options.height = 200;
    options.background = false;
    const Picture image = renderSurface(*grid, frontView(centre, 50 * scale), options);
    const double pixel = 50.0 / 200;
    // A quarter of a pixel on every side is the error of four samples.
    EXPECT_NEAR(alphaSum(image) * pixel * pixel, kPi * 400, 2 * kPi * 20 * pixel / 4) << "scale " << scale;
  }
}

/// The exact ray through a position of the picture, for the camera of `frontView` or a perspective one at the
/// same position.
ViewRay exactRay(const Camera& camera, double x, double y, double aspect) {
  const double half = camera.orthographicHeight > 0 ? camera.orthographicHeight / 2
                                                    : std::tan(camera.verticalFov * kPi / 360);
  const Vec3d offset(half * aspect * x, half * y, 0);
  if (camera.orthographicHeight > 0) return ViewRay(camera.position + offset, Vec3d(0, 0, -1));
  return ViewRay(camera.position, (offset + Vec3d(0, 0, -1)).unit());
}

TEST(Render, DepthAndNormalsAreThoseOfTheSphere) {
  for (const double scale : {6e-4, 1.0, 250.0}) {
    for (const double fov : {0.0, 40.0}) {
      const double radius = 20 * scale;
      const Vec3d centre(31.3 * scale, -17.7 * scale, 55.1 * scale);
      const auto grid = sphere(radius, centre, scale);
      Camera camera = frontView(centre, 75 * scale);
      camera.orthographicHeight = fov > 0 ? 0 : 50 * scale;
      camera.verticalFov = fov;
      RenderOptions options;
      options.width = 150, options.height = 120;
      options.background = false, options.channels = true;
      const Picture image = renderSurface(*grid, camera, options);
      int seen = 0;
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
          const size_t n = size_t(y) * size_t(image.width) + size_t(x);
          EXPECT_EQ(image.mask[n], image.rgba[4 * n + 3]);
          const ViewRay ray =
              exactRay(camera, 2 * (x + 0.5) / image.width - 1, 1 - 2 * (y + 0.5) / image.height, 1.25);
          const Vec3d toCentre = centre - ray.eye();
          const double along = toCentre.dot(ray.dir());
          const double miss = std::sqrt(std::max(0.0, toCentre.lengthSqr() - along * along));
          if (miss > radius + 2 * scale) {
            EXPECT_EQ(image.mask[n], 0);
            EXPECT_EQ(image.depth[n], kFarAway);
            EXPECT_EQ(image.normal[3 * n], 0);
          }
          const double into = std::sqrt(std::max(0.0, radius * radius - miss * miss));
          // Trilinear interpolation moves the surface by at most h^2 / 4R, and along the ray by that
          // over the cosine.
          if (into / radius < 0.1) continue;
          ++seen;
          const Vec3d point = ray(along - into);
          EXPECT_NEAR(image.depth[n], camera.position.z() - point.z(), scale / 2);
          const Vec3d normal(image.normal[3 * n], image.normal[3 * n + 1], image.normal[3 * n + 2]);
          EXPECT_NEAR(normal.length(), 1, 1e-5);
          EXPECT_GT(normal.dot((point - centre).unit()), std::cos(kPi / 180)) << x << " " << y;
        }
      }
      EXPECT_GT(seen, 1000);
    }
  }
}

/// Mean of red over the left or right half of the visible surface.
double brightness(const Picture& image, bool right) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = right ? image.width / 2 : 0; x < (right ? image.width : image.width / 2); ++x)
      sum += image.rgba[4 * (size_t(y) * size_t(image.width) + size_t(x))];
  return sum;
}

TEST(Render, TheLightComesFromWhereItIsSaid) {
  const auto grid = sphere(20, {0, 0, 0}, 1);
  RenderOptions options;
  options.width = options.height = 60;
  options.background = false;
  options.light = {-1, 0, 0};
  const Picture fromRight = renderSurface(*grid, frontView({0, 0, 0}, 50), options);
  EXPECT_GT(brightness(fromRight, true), 1.5 * brightness(fromRight, false));
  options.intensity = 2;
  EXPECT_GT(brightness(renderSurface(*grid, frontView({0, 0, 0}, 50), options), true),
            1.5 * brightness(fromRight, true));
  options.intensity = -1;
  EXPECT_THROW(renderSurface(*grid, frontView({0, 0, 0}, 50), options), InputError);
}

TEST(Render, ACameraInsideTheSurfaceIsRefused) {
  const auto grid = sphere(20, {0, 0, 0}, 1);
  Camera camera;
  camera.position = {3, 2, 1};
  camera.target = {0, 0, 0};
  EXPECT_THROW(renderSurface(*grid, camera), InputError);
  camera.orthographicHeight = 50;  // sees it from outside nevertheless
  EXPECT_NO_THROW(renderSurface(*grid, camera));
}

TEST(Camera, TurnsAboutUpCounterClockwise) {
  Camera camera;
  camera.target = {1, 2, 3};
  camera.position = {1, 5, 13};
  const Camera quarter = turned(camera, kPi / 2);
  EXPECT_LT((quarter.position - Vec3d(11, 5, 3)).length(), 1e-12);
  EXPECT_EQ(quarter.target, camera.target);
}

TEST(Camera, ATurntableSeesAllFromEverySide) {
  FloatGrid::Ptr bar = FloatGrid::create(3.0f);
  bar->setGridClass(openvdb::GRID_LEVEL_SET);
  const openvdb::BBoxd box(Vec3d(-30, -3, -4), Vec3d(30, 3, 4));
  for (const double fov : {0.0, 40.0}) {
    FrameAllOptions view;
    view.verticalFov = fov;
    view.allRound = true;
    const Camera camera = frameAll({box}, view);
    double widest = 0;
    for (int n = 0; n < 100; ++n) {
      const Camera at = turned(camera, 2 * kPi * n / 100);
      const ViewBasis basis = basisOf(at);
      for (int c = 0; c < 8; ++c) {
        const Vec3d corner((c & 1 ? box.max() : box.min()).x(), (c & 2 ? box.max() : box.min()).y(),
                           (c & 4 ? box.max() : box.min()).z());
        const Vec3d p = corner - at.position;
        const double half =
            fov > 0 ? std::tan(fov * kPi / 360) * -p.dot(basis.back) : at.orthographicHeight / 2;
        widest = std::max(
            {widest, std::abs(p.dot(basis.up)) / half, std::abs(p.dot(basis.right)) / half / view.aspect});
      }
    }
    EXPECT_LT(widest, 1);
    EXPECT_GT(widest, 0.93);  // the object fills the picture
  }
}

TEST(Render, FrameAllSeesEveryBoxWhole) {
  const auto a = sphere(10, {0, 0, 0}, 1), b = sphere(15, {60, 20, -30}, 1);
  for (const double fov : {0.0, 10.0, 60.0}) {
    FrameAllOptions view;
    view.verticalFov = fov;
    const Camera camera = frameAll({surfaceBox(*a), surfaceBox(*b)}, view);
    RenderOptions options;
    options.width = 160, options.height = 120;
    options.background = false;
    for (const auto& grid : {a, b}) {
      const Picture image = renderSurface(*grid, camera, options);
      EXPECT_GT(alphaSum(image), 0.005 * image.width * image.height);
      for (int x = 0; x < image.width; ++x) {
        ASSERT_EQ(image.rgba[4 * size_t(x) + 3], 0);
        ASSERT_EQ(image.rgba[4 * (size_t(image.height - 1) * image.width + x) + 3], 0);
      }
      for (int y = 0; y < image.height; ++y) {
        ASSERT_EQ(image.rgba[4 * size_t(y) * image.width + 3], 0);
        ASSERT_EQ(image.rgba[4 * (size_t(y) * image.width + image.width - 1) + 3], 0);
      }
    }
  }
}

TEST(Render, SameBytesForAnyThreadCount) {
  const auto grid = sphere(20, {0, 0, 0}, 1);
  const Camera camera = frameAll({surfaceBox(*grid)});
  RenderOptions options;
  options.width = 160, options.height = 120;
  std::vector<std::vector<float>> pictures;
  for (const size_t threads : {1, 2, 4})
    withThreads(threads, [&] { pictures.push_back(renderSurface(*grid, camera, options).rgba); });
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_EQ(pictures[0], pictures[2]);
}

TEST(Render, EmptyLevelSetGivesTheBackground) {
  const auto grid = FloatGrid::create(3.0f);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  RenderOptions options;
  options.width = 8, options.height = 6;
  const Picture image = renderSurface(*grid, Camera(), options);
  EXPECT_EQ(alphaSum(image), 48);
  EXPECT_THROW(surfaceBox(*grid), GeometryError);
}

TEST(Render, RefusesWhatItCannotDraw) {
  const auto grid = sphere(5, {0, 0, 0}, 1);
  RenderOptions options;
  options.width = 0;
  EXPECT_THROW(renderSurface(*grid, Camera(), options), InputError);
  options = {};
  options.samples = 65;
  EXPECT_THROW(renderSurface(*grid, Camera(), options), InputError);
  Camera alongUp;
  alongUp.position = {0, 5, 0};
  EXPECT_THROW(renderSurface(*grid, alongUp), InputError);
  EXPECT_THROW(frameAll({}), InputError);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  EXPECT_THROW(renderSurface(*grid, Camera()), InputError);
}

Picture plain(int width, int height, float value) {
  return {width, height, std::vector<float>(size_t(4) * width * height, value)};
}

TEST(ContactSheet, TilesInReadingOrderWithCaptions) {
  std::vector<Tile> tiles;
  for (int n = 0; n < 5; ++n) tiles.push_back({plain(40, 30, 0.1f * float(n + 1)), n == 4 ? "t=0.25" : ""});
  const Picture sheet = contactSheet(tiles);
  ASSERT_EQ(sheet.width, 3 * 42 - 2);
  ASSERT_EQ(sheet.height, 2 * 32 - 2);
  for (int n = 0; n < 5; ++n) {
    EXPECT_FLOAT_EQ(sheet.rgba[4 * (size_t(n / 3) * 32 * sheet.width + size_t(n % 3) * 42)],
                    0.1f * float(n + 1));
  }
  int letters = 0;
  for (int y = 32; y < 62; ++y) {
    for (int x = 42; x < 82; ++x) letters += sheet.rgba[4 * (size_t(y) * sheet.width + x)] > 0.8f;
  }
  EXPECT_GT(letters, 40);
  EXPECT_EQ(contactSheet(tiles, 1).height, 5 * 32 - 2);
}

TEST(ContactSheet, RefusesTilesOfDifferentSizes) {
  EXPECT_THROW(contactSheet({}), InputError);
  EXPECT_THROW(contactSheet({{plain(4, 4, 0), ""}, {plain(5, 4, 0), ""}}), InputError);
  EXPECT_THROW(contactSheet({{plain(4, 4, 0), ""}}, -1), InputError);
}

std::vector<png_byte> readPng(const std::string& path, png_uint_32 format) {
  png_image header = {};
  header.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&header, path.c_str())) << header.message;
  header.format = format;
  std::vector<png_byte> pixels(PNG_IMAGE_SIZE(header));
  EXPECT_TRUE(png_image_finish_read(&header, nullptr, pixels.data(), 0, nullptr)) << header.message;
  return pixels;
}

TEST(Png, WritesSrgbAndStraightAlpha) {
  const std::string path = testing::TempDir() + "slicemorph_png_test.png";
  writePng(path, {2, 1, {0.5f, 0, 2, 1, 0.002f, 1, -1, 1}});
  EXPECT_EQ(readPng(path, PNG_FORMAT_RGB), (std::vector<png_byte>{188, 0, 255, 7, 255, 0}));
  writePng(path, {1, 1, {0.25f, 0, 0.5f, 0.5f}});  // premultiplied
  EXPECT_EQ(readPng(path, PNG_FORMAT_RGBA), (std::vector<png_byte>{188, 0, 255, 128}));
  std::filesystem::remove(path);
  EXPECT_THROW(writePng(testing::TempDir() + "no/such/folder/a.png", plain(1, 1, 1)), IoError);
}

}  // namespace
}  // namespace slicemorph

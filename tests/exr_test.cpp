#include "engine/errors.h"
#include "engine/slices/section.h"
#include "io/exr_writer.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfStandardAttributes.h>
#include <ImfVecAttribute.h>
#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
const Vec3d kCentre(3.2, -4.1, 7.7);
constexpr double kRadius = 10, kVoxel = 0.5;

FloatGrid::Ptr sphere() {
  return openvdb::tools::createLevelSetSphere<FloatGrid>(float(kRadius), openvdb::Vec3f(kCentre),
                                                         float(kVoxel));
}

Vec3d worldOf(const SectionPlane& plane, double i, double j) {
  return plane.origin + plane.pixelSize * (i * plane.xAxis + j * plane.yAxis);
}

/// A dense box of active voxels longest along its own x; rotated and with different voxel sizes.
FloatGrid::Ptr obliqueBar() {
  auto transform = openvdb::math::Transform::createLinearTransform(1.0);
  transform->preScale(Vec3d(0.5, 0.7, 1.1));
  transform->postRotate(0.6, openvdb::math::Z_AXIS);
  transform->postRotate(-0.4, openvdb::math::X_AXIS);
  transform->postTranslate({10, 20, 30});
  auto grid = FloatGrid::create(0.0f);
  grid->setTransform(transform);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->fill(openvdb::CoordBBox({-40, -8, -4}, {40, 8, 4}), 1.0f);
  return grid;
}

TEST(Section, SamplesTheDistanceOfASphere) {
  const auto grid = sphere();
  // Trilinear interpolation over a voxel: at most h^2 / 8 times the sum of the second derivatives, 2 /
  // distance.
  const double tolerance = kVoxel * kVoxel / 8 * 2 / (kRadius - 3 * kVoxel) + 1e-4;
  for (const Vec3d& axis : {Vec3d(0, 0, 1), Vec3d(1, 2, -0.5)}) {
    const auto slices = sections(*grid, {axis, 9, 0.37});
    ASSERT_EQ(slices.size(), 9u);
    for (const Section& slice : slices) {
      ASSERT_EQ(slice.values.size(), size_t(slices[0].plane.width) * slices[0].plane.height);
      for (int j = 0; j < slice.plane.height; ++j) {
        for (int i = 0; i < slice.plane.width; ++i) {
          const double exact = (worldOf(slice.plane, i, j) - kCentre).length() - kRadius;
          if (std::abs(exact) > 1.5 * kVoxel) continue;  // clamped farther out
          ASSERT_NEAR(slice.values[size_t(j) * slice.plane.width + i], exact, tolerance);
        }
      }
    }
  }
}

TEST(Section, SlabsAddUpToTheVolume) {
  const auto slices = sections(*sphere(), {Vec3d(0.3, 1, 0.2), 60, 0});
  const double thickness = (slices[1].plane.origin - slices[0].plane.origin).dot(slices[0].plane.normal);
  double volume = 0;
  for (const Section& slice : slices) {
    const double pixel = slice.plane.pixelSize;
    for (const float d : slice.values)
      volume += std::clamp(0.5 - d / pixel, 0.0, 1.0) * pixel * pixel * thickness;
  }
  EXPECT_NEAR(volume / (4.0 / 3 * kPi * std::pow(kRadius, 3)), 1, 0.005);
}

TEST(Section, PlanesAreRightHandedAndOrdered) {
  for (const Vec3d& axis :
       {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(0, -3, 0), Vec3d(0, 0, 1), Vec3d(1, 1, 1)}) {
    const auto planes = sectionPlanes(*sphere(), {axis, 5, 0});
    for (size_t n = 0; n < planes.size(); ++n) {
      const SectionPlane& plane = planes[n];
      EXPECT_LT((plane.xAxis.cross(plane.yAxis) - plane.normal).length(), 1e-12);
      EXPECT_NEAR(plane.u, -0.8 + 0.4 * double(n), 1e-12);
      EXPECT_EQ(plane.index, int(n));
      EXPECT_NEAR((plane.origin - planes[0].origin).dot(plane.normal), double(n) * 4, 3 * kVoxel);
      if (axis.lengthSqr() > 0) {
        EXPECT_LT((plane.normal - axis.unit()).length(), 1e-12);
      }
    }
  }
  const auto straight = sectionPlanes(*sphere(), {Vec3d(0, 0, 1), 1, 0});
  EXPECT_EQ(straight[0].xAxis, Vec3d(1, 0, 0));
  EXPECT_EQ(straight[0].yAxis, Vec3d(0, 1, 0));
  EXPECT_EQ(straight[0].u, 0);
}

TEST(Section, FindsThePrincipalAxisUnderAnyLinearTransform) {
  const auto grid = obliqueBar();
  const Vec3d along = (grid->indexToWorld(Vec3d(1, 0, 0)) - grid->indexToWorld(Vec3d(0.0))).unit();
  const auto planes = sectionPlanes(*grid, {{0, 0, 0}, 10, 0});
  EXPECT_GT(std::abs(planes[0].normal.dot(along)), std::cos(0.5 * kPi / 180));
  EXPECT_NEAR((planes[9].origin - planes[0].origin).length(), 0.9 * 81 * 0.5, 0.9);
  EXPECT_DOUBLE_EQ(planes[0].pixelSize, 0.5);
}

TEST(Section, ReproducesALinearFunctionExactly) {
  const auto grid = obliqueBar();
  const Vec3d slope(0.3, -0.2, 0.5);
  for (auto it = grid->beginValueOn(); it; ++it)
    it.setValue(float(slope.dot(grid->indexToWorld(it.getCoord()))));
  const openvdb::BBoxd inside(Vec3d(-40, -8, -4), Vec3d(40, 8, 4));
  size_t checked = 0;
  for (const Section& slice : sections(*grid, {Vec3d(0.2, 0.3, 1), 7, 0.4})) {
    for (int j = 0; j < slice.plane.height; ++j) {
      for (int i = 0; i < slice.plane.width; ++i) {
        const Vec3d world = worldOf(slice.plane, i, j);
        if (!inside.isInside(grid->worldToIndex(world))) continue;
        ASSERT_NEAR(slice.values[size_t(j) * slice.plane.width + i], slope.dot(world), 1e-4);
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 1000u);
}

TEST(Section, SameValuesForAnyThreadCount) {
  const auto grid = sphere();
  std::vector<std::vector<float>> values;
  for (const size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    values.emplace_back();
    for (const Section& slice : sections(*grid, {{0, 0, 0}, 12, 0})) {
      values.back().insert(values.back().end(), slice.values.begin(), slice.values.end());
    }
  }
  EXPECT_EQ(values[0], values[1]);
  EXPECT_EQ(values[0], values[2]);
}

TEST(Section, RefusesBadOptionsAndEmptyGrids) {
  const auto grid = sphere();
  EXPECT_THROW(sectionPlanes(*grid, {{0, 0, 0}, 0, 0}), InputError);
  EXPECT_THROW(sectionPlanes(*grid, {{0, 0, 0}, 4, -1}), InputError);
  EXPECT_THROW(sectionPlanes(*grid, {{0, 0, 0}, 4, 1e-9}), InputError);
  EXPECT_THROW(sectionPlanes(*grid, {{NAN, 0, 0}, 4, 0}), InputError);
  EXPECT_THROW(sectionPlanes(*FloatGrid::create(1.0f), {}), GeometryError);
}

std::vector<float> readChannel(Imf::InputFile& file, const char* name) {
  const auto size = file.header().dataWindow().max + Imath::V2i(1, 1);
  std::vector<float> values(size_t(size.x) * size.y);
  Imf::FrameBuffer buffer;
  buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), sizeof(float),
                                 sizeof(float) * size_t(size.x)));
  file.setFrameBuffer(buffer);
  file.readPixels(0, size.y - 1);
  return values;
}

TEST(Exr, SliceHoldsItsValuesAndItsPlace) {
  const auto slices = sections(*sphere(), {Vec3d(1, 2, 3), 5, 0});
  const Section& slice = slices[1];
  const std::string path = testing::TempDir() + "slicemorph_exr_test.exr";
  writeSliceExr(path, slice);
  {
    Imf::InputFile file(path.c_str());
    const Imf::Header& header = file.header();
    EXPECT_EQ(header.compression(), Imf::ZIP_COMPRESSION);
    EXPECT_EQ(readChannel(file, "surface.sdf"), slice.values);
    const auto coverage = readChannel(file, "coverage");
    for (size_t n = 0; n < coverage.size(); ++n) {
      ASSERT_GE(coverage[n], 0);
      ASSERT_LE(coverage[n], 1);
      ASSERT_EQ(coverage[n] > 0.5f, slice.values[n] < 0);
    }
    EXPECT_EQ(header.typedAttribute<Imf::IntAttribute>("sliceIndex").value(), 1);
    EXPECT_EQ(header.typedAttribute<Imf::IntAttribute>("sliceCount").value(), 5);
    EXPECT_FLOAT_EQ(header.typedAttribute<Imf::FloatAttribute>("sliceU").value(), -0.4f);
    const Imath::V3f normal = header.typedAttribute<Imf::V3fAttribute>("sliceNormal").value();
    EXPECT_NEAR(normal.dot(Imath::V3f(1, 2, 3).normalized()), 1, 1e-6);

    const auto& toWorld = header.typedAttribute<Imf::M44fAttribute>("pixelToWorld").value();
    const Imath::V3f pixel = Imath::V3f(11, 7, 0) * toWorld;
    const Vec3d expected = worldOf(slice.plane, 11, 7);
    EXPECT_LT((Vec3d(pixel.x, pixel.y, pixel.z) - expected).length(), 1e-4);
    const Imath::V3f seen = pixel * Imf::worldToCamera(header);
    EXPECT_NEAR(seen.x, (11 - (slice.plane.width - 1) / 2.0) * slice.plane.pixelSize, 1e-4);
    EXPECT_NEAR(seen.y, ((slice.plane.height - 1) / 2.0 - 7) * slice.plane.pixelSize, 1e-4);
    EXPECT_NEAR(seen.z, 0, 1e-4);
  }
  std::filesystem::remove(path);
}

TEST(Exr, OtherGridsKeepTheirName) {
  const std::string path = testing::TempDir() + "slicemorph_exr_fog.exr";
  const Section slice = sections(*obliqueBar(), {{0, 0, 0}, 1, 1})[0];
  writeSliceExr(path, slice, {false, "density"});
  Imf::InputFile file(path.c_str());
  EXPECT_EQ(readChannel(file, "density"), slice.values);
  EXPECT_EQ(file.header().channels().findChannel("coverage"), nullptr);
  std::filesystem::remove(path);
}

TEST(Exr, PictureHasItsFurtherChannels) {
  const std::string path = testing::TempDir() + "slicemorph_exr_channels.exr";
  Picture image{2, 1, {0, 0, 0, 1, 0, 0, 0, 1}};
  image.mask = {0.25f, 1};
  image.depth = {kFarAway, 7.5f};
  image.normal = {0, 0, 0, 0.1f, 0.2f, 0.3f};
  writePictureExr(path, image);
  Imf::InputFile file(path.c_str());
  EXPECT_EQ(readChannel(file, "mask"), image.mask);
  EXPECT_EQ(readChannel(file, "Z"), image.depth);
  EXPECT_EQ(readChannel(file, "N.X"), (std::vector<float>{0, 0.1f}));
  EXPECT_EQ(readChannel(file, "N.Z"), (std::vector<float>{0, 0.3f}));
  std::filesystem::remove(path);
}

TEST(Exr, PictureIsLinearAndWholeOrNotThere) {
  const std::string path = testing::TempDir() + "slicemorph_exr_picture.exr";
  writePictureExr(path, {2, 1, {0.1f, 0.2f, 0.3f, 1, 4, 5, 6, 0.5f}});
  Imf::InputFile file(path.c_str());
  EXPECT_EQ(readChannel(file, "R"), (std::vector<float>{0.1f, 4}));
  EXPECT_EQ(readChannel(file, "A"), (std::vector<float>{1, 0.5f}));
  std::filesystem::remove(path);
  EXPECT_THROW(writePictureExr(testing::TempDir() + "no/such/folder/a.exr", {1, 1, {0, 0, 0, 1}}), IoError);
}

}  // namespace
}  // namespace slicemorph

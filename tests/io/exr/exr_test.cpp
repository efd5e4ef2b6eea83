#include "engine/reconstruct/sections_to_grid.h"
#include "engine/sections/place_sections.h"
#include "engine/sections/section.h"
#include "io/exr/exr_slice_reader.h"
#include "io/exr/exr_slice_writer.h"
#include "io/exr/exr_writer.h"
#include "slicemorph/errors.h"
#include "tests/support/shapes.h"
#include "tests/support/with_threads.h"

#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfStandardAttributes.h>
#include <ImfVecAttribute.h>
#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
const Vec3d kCentre(3.2, -4.1, 7.7);
constexpr double kRadius = 10, kVoxel = 0.5;

FloatGrid::Ptr sphere() {
  return openvdb::tools::createLevelSetSphere<FloatGrid>(float(kRadius), openvdb::Vec3f(kCentre),
                                                         float(kVoxel));
}

struct Slice {
  SectionPlane plane;
  std::vector<float> values;
};

std::vector<Slice> sections(const FloatGrid::ConstPtr& grid, const SectionOptions& options) {
  std::vector<Slice> slices;
  for (const SectionPlane& plane : sectionPlanes({grid}, options))
    slices.push_back({plane, sampleSection(*grid, plane).values});
  return slices;
}

/// A dense box of active voxels, longest along its own x, rotated and with unequal voxel sides.
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
  // Error of trilinear interpolation: at most h^2 / 8 times the sum of the second derivatives, 2 / distance.
  const double tolerance = kVoxel * kVoxel / 8 * 2 / (kRadius - 3 * kVoxel) + 1e-4;
  for (const Vec3d& axis : {Vec3d(0, 0, 1), Vec3d(1, 2, -0.5)}) {
    const auto slices = sections(grid, {axis, 9, 0.37});
    ASSERT_EQ(slices.size(), 9u);
    for (const Slice& slice : slices) {
      ASSERT_EQ(slice.values.size(), size_t(slices[0].plane.width) * slices[0].plane.height);
      for (int j = 0; j < slice.plane.height; ++j) {
        for (int i = 0; i < slice.plane.width; ++i) {
          const double exact = (slice.plane.toWorld(i, j) - kCentre).length() - kRadius;
          if (std::abs(exact) > 1.5 * kVoxel) continue;  // clamped farther out
          ASSERT_NEAR(slice.values[size_t(j) * slice.plane.width + i], exact, tolerance);
        }
      }
    }
  }
}

TEST(Section, SlabsAddUpToTheVolume) {
  const auto slices = sections(sphere(), {Vec3d(0.3, 1, 0.2), 60, 0});
  const double thickness = (slices[1].plane.origin - slices[0].plane.origin).dot(slices[0].plane.normal);
  double volume = 0;
  for (const Slice& slice : slices) {
    const double pixel = slice.plane.pixelSize;
    for (const float d : slice.values)
      volume += std::clamp(0.5 - d / pixel, 0.0, 1.0) * pixel * pixel * thickness;
  }
  EXPECT_NEAR(volume / (4.0 / 3 * kPi * std::pow(kRadius, 3)), 1, 0.005);
}

TEST(Section, PlanesAreRightHandedAndOrdered) {
  for (const Vec3d& axis :
       {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(0, -3, 0), Vec3d(0, 0, 1), Vec3d(1, 1, 1)}) {
    const auto planes = sectionPlanes({sphere()}, {axis, 5, 0});
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
  const auto straight = sectionPlanes({sphere()}, {Vec3d(0, 0, 1), 1, 0});
  EXPECT_EQ(straight[0].xAxis, Vec3d(1, 0, 0));
  EXPECT_EQ(straight[0].yAxis, Vec3d(0, 1, 0));
  EXPECT_EQ(straight[0].u, 0);
}

TEST(Section, FindsThePrincipalAxisUnderAnyLinearTransform) {
  const auto grid = obliqueBar();
  const Vec3d along = (grid->indexToWorld(Vec3d(1, 0, 0)) - grid->indexToWorld(Vec3d(0.0))).unit();
  const auto planes = sectionPlanes({grid}, {{0, 0, 0}, 10, 0});
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
  for (const Slice& slice : sections(grid, {Vec3d(0.2, 0.3, 1), 7, 0.4})) {
    for (int j = 0; j < slice.plane.height; ++j) {
      for (int i = 0; i < slice.plane.width; ++i) {
        const Vec3d world = slice.plane.toWorld(i, j);
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
  for (const size_t threads : {1, 2, 4})
    withThreads(threads, [&] {
      values.emplace_back();
      for (const Slice& slice : sections(grid, {{0, 0, 0}, 12, 0})) {
        values.back().insert(values.back().end(), slice.values.begin(), slice.values.end());
      }
    });
  EXPECT_EQ(values[0], values[1]);
  EXPECT_EQ(values[0], values[2]);
}

TEST(Section, RefusesBadOptionsAndEmptyGrids) {
  const auto grid = sphere();
  EXPECT_THROW(sectionPlanes({grid}, {{0, 0, 0}, 0, 0}), InputError);
  EXPECT_THROW(sectionPlanes({grid}, {{0, 0, 0}, 4, -1}), InputError);
  EXPECT_THROW(sectionPlanes({grid}, {{0, 0, 0}, 4, 1e-9}), InputError);
  EXPECT_THROW(sectionPlanes({grid}, {{NAN, 0, 0}, 4, 0}), InputError);
  EXPECT_THROW(sectionPlanes({FloatGrid::create(1.0f)}, {}), GeometryError);
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
  const auto grid = sphere();
  const auto slices = sections(grid, {Vec3d(1, 2, 3), 5, 0});
  const Slice& slice = slices[1];
  const std::string path = testing::TempDir() + "slicemorph_exr_test.exr";
  writeSliceExr(path, {{"surface", grid}}, sectionPlanes({grid}, {Vec3d(1, 2, 3), 5, 0}), 1);
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
    EXPECT_DOUBLE_EQ(header.typedAttribute<Imf::DoubleAttribute>("sliceU").value(), -0.4);
    const Imath::V3d normal = header.typedAttribute<Imf::V3dAttribute>("sliceNormal").value();
    EXPECT_NEAR(normal.dot(Imath::V3d(1, 2, 3).normalized()), 1, 1e-12);

    const auto& toWorld = header.typedAttribute<Imf::M44dAttribute>("pixelToWorld").value();
    const Imath::V3d pixel = Imath::V3d(11, 7, 0) * toWorld;
    const Vec3d expected = slice.plane.toWorld(11, 7);
    EXPECT_LT((Vec3d(pixel.x, pixel.y, pixel.z) - expected).length(), 1e-12 * expected.length());
    const Imath::V3f seen = Imath::V3f(pixel) * Imf::worldToCamera(header);
    EXPECT_NEAR(seen.x, (11 - (slice.plane.width - 1) / 2.0) * slice.plane.pixelSize, 1e-4);
    EXPECT_NEAR(seen.y, ((slice.plane.height - 1) / 2.0 - 7) * slice.plane.pixelSize, 1e-4);
    EXPECT_NEAR(seen.z, 0, 1e-4);
    const Imath::V3f inWindow = Imath::V3f(pixel) * Imf::worldToNDC(header);
    const Imath::Box2i display = header.displayWindow();
    EXPECT_NEAR(inWindow.x, 2 * 11.5 / (display.max.x + 1) - 1, 1e-5);
    EXPECT_NEAR(inWindow.y, 1 - 2 * 7.5 / (display.max.y + 1), 1e-5);
  }
  std::filesystem::remove(path);
}

TEST(Exr, OtherGridsKeepTheirName) {
  const std::string path = testing::TempDir() + "slicemorph_exr_fog.exr";
  const auto grid = obliqueBar();
  const auto planes = sectionPlanes({grid}, {{0, 0, 0}, 1, 1});
  writeSliceExr(path, {{"density", grid}}, planes, 0);
  Imf::InputFile file(path.c_str());
  EXPECT_EQ(readChannel(file, "density.Y"), sampleSection(*grid, planes[0]).values);
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
  EXPECT_EQ(readChannel(file, "N.X"), (std::vector<float>{0, half(0.1f)}));
  EXPECT_EQ(readChannel(file, "N.Z"), (std::vector<float>{0, half(0.3f)}));
  std::filesystem::remove(path);
}

TEST(Section, LeaningPlanesStandAcrossTheSpine) {
  // An eighth of a ring of radius 20: turn rates are per chart unit, half the arc's length.
  const double ring = 20, half = ring * kPi / 8;
  Chart chart;
  chart.scale = Vec3d(half, 1, 1);
  chart.bend = Bend(1, std::vector<Vec3d>(Bend::kStations, Vec3d(0, 0, half / ring)));
  const Vec3d middle(0, ring, 0);
  const auto body = shapes::levelSet(shapes::torus(Vec3d(0.0), ring, 3), shapes::cube(Vec3d(0.0), 25), 0.5);
  const auto moved = body->deepCopy();
  moved->transform().postTranslate(middle);
  // Only the part near the arc: a box clips it.
  for (auto it = moved->beginValueAll(); it; ++it) {
    const Vec3d p = moved->indexToWorld(it.getCoord());
    if (std::atan2(std::abs(p[0]), ring - p[1]) > kPi / 8) it.setValue(1.5f), it.setValueOff();
  }
  const auto planes = sectionPlanesAlong(chart, {moved}, 7);
  ASSERT_EQ(planes.size(), 7u);
  for (const SectionPlane& plane : planes) {
    EXPECT_LT(std::abs((middle - plane.origin).dot(plane.normal)), 0.02 * ring) << "through the ring's axis";
    EXPECT_LT((plane.xAxis.cross(plane.yAxis) - plane.normal).length(), 1e-9);
    EXPECT_EQ(plane.width, planes[0].width);
  }
  EXPECT_LT(planes[0].normal.dot(planes[6].normal), std::cos(0.8 * kPi / 4));
}

TEST(Section, GivenPlanesKeepTheirOriginOnAPixel) {
  const auto planes = sectionPlanesAt({{kCentre, {0, 0, 2}}, {kCentre, {1, 1, 0}}}, {sphere()}, 0.3);
  for (const SectionPlane& plane : planes) {
    const double i = (kCentre - plane.origin).dot(plane.xAxis) / 0.3,
                 j = (kCentre - plane.origin).dot(plane.yAxis) / 0.3;
    EXPECT_NEAR(i, std::round(i), 1e-9);
    EXPECT_NEAR(j, std::round(j), 1e-9);
    // All of the disk and a margin of three to five pixels.
    EXPECT_GE(plane.width * 0.3, 2 * kRadius + 6 * 0.3);
    EXPECT_LE(plane.width * 0.3, 2 * kRadius + 2 * kVoxel + 10 * 0.3);
  }
  EXPECT_THROW(sectionPlanesAt({{kCentre + Vec3d(0, 0, 11), {0, 0, 1}}}, {sphere()}), InputError);
}

/// Writes slices of a grid, reads them and reconstructs the grid.
openvdb::GridBase::Ptr throughFiles(const SliceGrid& grid, const std::vector<SectionPlane>& planes,
                                    bool parts, const SliceExrOptions& options = {}) {
  const std::string folder = testing::TempDir() + "slicemorph_slices";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  Progress progress;
  if (parts)
    writeSlicesExr(folder + "/all.exr", {grid}, planes, options, progress);
  else
    for (size_t n = 0; n < planes.size(); ++n)
      writeSliceExr(folder + "/s." + std::to_string(1001 + n) + ".exr", {grid}, planes, n, options);
  const ExrSlices read = readSliceExrs(parseInput(folder + (parts ? "/all.exr" : "/s.####.exr")));
  EXPECT_EQ(read.planes.size(), planes.size());
  const auto result = gridOfSections(read.planes, read.grids.at(0), planes[0].pixelSize);
  std::filesystem::remove_all(folder);
  return result;
}

TEST(ExrReconstruct, ALinearFunctionComesBackExactly) {
  const auto grid = obliqueBar();
  const Vec3d slope(0.3, -0.2, 0.5);
  for (auto it = grid->beginValueOn(); it; ++it)
    it.setValue(float(slope.dot(grid->indexToWorld(it.getCoord()))));
  grid->setName("heat");
  // Leaning planes: turned about an axis in front of the bar.
  const Vec3d along = (grid->indexToWorld(Vec3d(1, 0, 0)) - grid->indexToWorld(Vec3d(0.0))).unit();
  const Vec3d across = (grid->indexToWorld(Vec3d(0, 1, 0)) - grid->indexToWorld(Vec3d(0.0))).unit();
  std::vector<PlaneInSpace> given;
  for (int n = 0; n < 30; ++n) {
    const double s = (n - 14.5) * 1.2;
    given.push_back({grid->indexToWorld(Vec3d(0.0)) + s * along, along + 0.01 * s * across});
  }
  const auto planes = sectionPlanesAt(given, {grid}, 0.4);
  for (const bool parts : {false, true}) {
    const auto back = openvdb::gridPtrCast<FloatGrid>(
        throughFiles({"heat", grid}, planes, parts, {false, "piz", parts ? 32 : 0}));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->getName(), "heat");
    EXPECT_EQ(back->getGridClass(), openvdb::GRID_FOG_VOLUME);
    EXPECT_NEAR(back->voxelSize()[0], 0.4, 1e-12);
    // Two voxels and a pixel inside the bar, where every sample depends on the bar's values alone.
    const openvdb::BBoxd inside(Vec3d(-30, -6, -2), Vec3d(30, 6, 2));
    size_t checked = 0;
    for (auto it = back->cbeginValueOn(); it; ++it) {
      const Vec3d world = back->indexToWorld(it.getCoord());
      if (!it.isVoxelValue() || !inside.isInside(grid->worldToIndex(world))) continue;
      // Single precision of values below 30, through two interpolations.
      ASSERT_NEAR(*it, slope.dot(world), 3e-5);
      ++checked;
    }
    EXPECT_GT(checked, 5000u);
  }
}

TEST(ExrReconstruct, ALevelSetComesBackAsALevelSet) {
  const auto grid = sphere();
  grid->setName("ball");
  const auto planes = sectionPlanes({grid}, {Vec3d(1, 2, -0.5), 45, 0});
  const auto back = openvdb::gridPtrCast<FloatGrid>(throughFiles({"ball", grid}, planes, true));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_EQ(back->getName(), "ball");
  EXPECT_NEAR(back->background(), 3 * kVoxel, 1e-6);
  double surface = 0, worst = 0, band = 0;
  size_t near = 0, all = 0;
  for (auto it = back->cbeginValueOn(); it; ++it) {
    const double exact = (back->indexToWorld(it.getCoord()) - kCentre).length() - kRadius;
    const double error = std::abs(*it - exact) / kVoxel;
    band += error, ++all, worst = std::max(worst, error);
    if (std::abs(exact) < kVoxel) surface += error, ++near;
  }
  // Three linear interpolations over a voxel at radius 20 voxels err by at most 1 / 8 * 2 / 19 each.
  EXPECT_LT(surface / double(near), 0.04);
  EXPECT_LT(band / double(all), 0.1);
  EXPECT_LT(worst, 0.5);
  // The whole shell of six voxels: its volume in voxels, to half a voxel at each of its two faces.
  const double r = kRadius / kVoxel;
  EXPECT_NEAR(double(all), 4.0 / 3 * kPi * (std::pow(r + 3, 3) - std::pow(r - 3, 3)), 4 * kPi * r * r);
}

TEST(ExrReconstruct, RefusesWhatIsNoSlice) {
  const std::string path = testing::TempDir() + "slicemorph_plain.exr";
  writePictureExr(path, {2, 1, {0.1f, 0.2f, 0.3f, 1, 4, 5, 6, 0.5f}});
  EXPECT_THROW(readSliceExrs(parseInput(path)), IoError);
  std::ofstream(path) << "no picture";
  EXPECT_THROW(readSliceExrs(parseInput(path)), IoError);
  std::filesystem::remove(path);
  const auto grid = sphere();
  const auto planes = sectionPlanes({grid}, {Vec3d(0, 0, 1), 1, 0});
  EXPECT_THROW(gridOfSections(planes, {grid, {sampleSection(*grid, planes[0])}}, kVoxel), InputError);
  const auto across =
      sectionPlanesAt({{kCentre, {0, 0, 1}}, {kCentre + Vec3d(1, 0, 1), {1, 0, -0.05}}}, {grid});
  EXPECT_THROW(
      gridOfSections(across, {grid, {sampleSection(*grid, across[0]), sampleSection(*grid, across[1])}},
                     kVoxel),
      InputError);
}

TEST(Exr, HalfFloatsAreRefusedWhereTheyCannotHoldAValue) {
  auto grid = FloatGrid::create(0.0f);
  grid->fill(openvdb::CoordBBox({0, 0, 0}, {5, 5, 5}), 70000.0f);
  const std::string path = testing::TempDir() + "slicemorph_exr_half.exr";
  EXPECT_THROW(writeSliceExr(path, {{"hot", grid}}, sectionPlanes({grid}, {Vec3d(0, 0, 1), 1, 0}), 0, {true}),
               InputError);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Exr, PictureIsLinearAndWholeOrNotThere) {
  const std::string path = testing::TempDir() + "slicemorph_exr_picture.exr";
  writePictureExr(path, {2, 1, {0.1f, 0.2f, 0.3f, 1, 4, 5, 6, 0.5f}});
  Imf::InputFile file(path.c_str());
  EXPECT_EQ(readChannel(file, "R"), (std::vector<float>{half(0.1f), 4}));
  EXPECT_EQ(readChannel(file, "A"), (std::vector<float>{1, 0.5f}));
  std::filesystem::remove(path);
  EXPECT_THROW(writePictureExr(testing::TempDir() + "no/such/folder/a.exr", {1, 1, {0, 0, 0, 1}}), IoError);
}

}  // namespace
}  // namespace slicemorph

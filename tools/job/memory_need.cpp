#include "tools/job/memory_need.h"

#include "engine/numerics/readable.h"
#include "tools/job/option_values.h"

#include <algorithm>

namespace slicemorph {
namespace {

// Peaks of resident memory were measured with /usr/bin/time -v on balls at 128, 256 and 512 voxels, two threads.
/// A morph of two took 600 MB and 71 to 75 bytes for each active voxel of its inputs, 8 of which these have already.
/// Pairs that are no balls took from 250 MB on.
constexpr double kMorphBase = 150e6, kMorphVoxel = 50;
/// A comparison's meshes and their trees took 60 bytes and more for each active voxel.
constexpr double kCompareVoxel = 40;
/// Numbers of a pixel of a picture: colour and opacity, and with the further channels mask, depth and normal. They
/// are there twice when they are written.
constexpr double kPictureNumbers = 4, kChannelNumbers = 5;

double bandVoxelsOf(const FloatGrid& grid) { return double(grid.activeVoxelCount()); }

std::string sizeText(const openvdb::Vec3d& size) {
  return formatNumber(size[0]) + " x " + formatNumber(size[1]) + " x " + formatNumber(size[2]) + " voxels";
}

}  // namespace

void require(const MemoryLimit& limit, const std::string& about, const MemoryNeed& need) {
  limit.require(need.bytes, about, need.what, need.advice);
}

MemoryNeed needOfMorph(const std::vector<LoadedObject>& inputs) {
  double voxels = 0;
  for (const LoadedObject& input : inputs) {
    voxels += bandVoxelsOf(*input.object.levelSet);
    for (const FloatGrid::ConstPtr& inner : input.object.inner)
      if (inner) voxels += bandVoxelsOf(*inner);
  }
  return {kMorphBase + kMorphVoxel * voxels,
          "matching shapes of " + readableCount(voxels) + " voxels around their surfaces",
          "a --voxel-size twice as large, or half the --resolution, takes a quarter for these"};
}

MemoryNeed needOfComparison(const FloatGrid& a, const FloatGrid& b) {
  const double voxels = bandVoxelsOf(a) + bandVoxelsOf(b);
  return {kCompareVoxel * voxels, "comparing surfaces of " + readableCount(voxels) + " voxels",
          "a --voxel-size twice as large takes a quarter"};
}

MemoryNeed needOfImage(const ImageLattice& lattice, double bytesPerVoxel) {
  const Vec3d size = lattice.size.asVec3d();
  return {size[0] * size[1] * size[2] * bytesPerVoxel, "an image of " + sizeText(size),
          "a larger --voxel-size, or --like an image of fewer voxels, makes a smaller one"};
}

MemoryNeed needOfDenseGrid(const openvdb::GridBase& grid) {
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  if (box.empty()) return {};
  const Vec3d size = box.dim().asVec3d();
  return {size[0] * size[1] * size[2] * double(sizeof(float)),
          "the grid '" + grid.getName() + "' as an image of " + sizeText(size),
          "images hold all of a box: a .vdb holds what is in it, and a larger --voxel-size makes a smaller "
          "image"};
}

MemoryNeed needOfPicture(const RenderOptions& options) {
  const double numbers = kPictureNumbers + (options.channels ? kChannelNumbers : 0);
  return {
      double(options.width) * options.height * numbers * double(sizeof(float)),
      "a picture of " + std::to_string(options.width) + " x " + std::to_string(options.height) + " pixels",
      "make it smaller (--size)"};
}

MemoryNeed needOfSlices(const std::vector<SectionPlane>& planes, size_t channels) {
  double most = 0;
  const SectionPlane* largest = nullptr;
  for (const SectionPlane& plane : planes)
    if (const double pixels = double(plane.width) * plane.height; pixels > most)
      most = pixels, largest = &plane;
  if (!largest) return {};
  return {most * double(channels) * double(sizeof(float)),
          "a slice of " + std::to_string(largest->width) + " x " + std::to_string(largest->height) +
              " pixels with " + std::to_string(channels) + " numbers each",
          "use a larger --pixel-size"};
}

}  // namespace slicemorph

/// Times of `slicemorph slice` as a ratio against writing the same pixels with OpenEXR alone in the same run:
/// 256 slices of a 256^3 volume with four channels (density, velocity), ZIP, one file per slice, both in
/// parallel. Usage: slicemorph_slice_benchmark [FOLDER [SIDE]]

#include "engine/sections/place_sections.h"
#include "engine/sections/section.h"
#include "io/exr/exr_slice_writer.h"
#include "slicemorph/progress.h"
#include "tools/job/stopwatch.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

using namespace slicemorph;

namespace {

constexpr size_t kTogether = 8;  // slices sampled together, as in exr_slice_writer.cpp
constexpr const char* kChannels[] = {"density.Y", "vel.X", "vel.Y", "vel.Z"};

/// A cube with a value at every voxel: a function of the voxel's position, from -1 to 1 along each axis.
template <typename Grid, typename Function>
typename Grid::Ptr filled(int side, const char* name, const Function& function) {
  const auto grid = Grid::create();
  grid->setName(name);
  using Leaf = typename Grid::TreeType::LeafNodeType;
  for (int x = 0; x < side; x += int(Leaf::DIM))
    for (int y = 0; y < side; y += int(Leaf::DIM))
      for (int z = 0; z < side; z += int(Leaf::DIM)) {
        auto* leaf = new Leaf({x, y, z});
        for (openvdb::Index n = 0; n < Leaf::SIZE; ++n)
          leaf->setValueOn(n, function(leaf->offsetToGlobalCoord(n).asVec3d() / (0.5 * side) - Vec3d(1)));
        grid->tree().addLeaf(leaf);
      }
  return grid;
}

std::string pathOf(const std::string& folder, size_t n) {
  return folder + "/slice." + std::to_string(n) + ".exr";
}

void writePlain(const std::string& path, const SectionPlane& plane,
                const std::vector<SectionValues>& layers) {
  Imf::Header header(plane.width, plane.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer buffer;
  const size_t count = size_t(plane.width) * size_t(plane.height);
  for (size_t c = 0; c < 4; ++c) {
    header.channels().insert(kChannels[c], Imf::Channel(Imf::FLOAT));
    const float* first = c == 0 ? layers[0].values.data() : layers[1].values.data() + (c - 1) * count;
    buffer.insert(kChannels[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(first)),
                                           sizeof(float), sizeof(float) * size_t(plane.width)));
  }
  Imf::OutputFile file(path.c_str(), header, 0);
  file.setFrameBuffer(buffer);
  file.writePixels(plane.height);
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path parent = argc > 1 ? argv[1] : std::filesystem::temp_directory_path();
  const std::string folder = (parent / "slicemorph_slice_benchmark").string();
  const int side = argc > 2 ? std::atoi(argv[2]) : 256;
  std::filesystem::create_directories(folder);
  openvdb::initialize();
  const auto density = filled<FloatGrid>(side, "density", [](const Vec3d& p) {
    return float(std::exp(-2 * p.lengthSqr()) *
                 (1 + 0.2 * std::sin(20 * p[0]) * std::cos(17 * p[1] + 9 * p[2])));
  });
  const auto velocity = filled<openvdb::Vec3SGrid>(side, "vel", [](const Vec3d& p) {
    return openvdb::Vec3s(float(-p[1] + 0.1 * std::sin(15 * p[2])), float(p[0]),
                          float(0.2 * std::cos(11 * p[0])));
  });
  const std::vector<SliceGrid> grids{{"density", density}, {"vel", velocity}};
  std::printf("%d slices of a %d^3 volume, 4 float channels, ZIP\n", side, side);
  for (const Vec3d& axis : {Vec3d(0, 0, 1), Vec3d(1, 2, 3)}) {
    const auto planes = sectionPlanes({density, velocity}, {axis, side, 0});
    Stopwatch watch;
    Progress silent;
    writeSliceFiles([&](size_t n) { return pathOf(folder, n); }, grids, planes, {}, silent);
    const double ours = watch.lap();
    writeSlicesExr(folder + "/all.exr", grids, planes, {}, silent);
    const double parts = watch.lap();
    std::vector<std::vector<SectionValues>> layers(planes.size());
    tbb::parallel_for(size_t(0), planes.size() / kTogether, [&](size_t b) {
      const auto first = planes.begin() + long(b * kTogether);
      for (const SliceGrid& grid : grids) {
        std::vector<SectionValues> values = sampleSections(*grid.grid, {first, first + kTogether});
        for (size_t n = 0; n < kTogether; ++n) layers[b * kTogether + n].push_back(std::move(values[n]));
      }
    });
    const double sampling = watch.lap();
    tbb::parallel_for(size_t(0), planes.size(),
                      [&](size_t n) { writePlain(pathOf(folder, n), planes[n], layers[n]); });
    const double plain = watch.lap();
    std::printf(
        "axis %g,%g,%g, %d x %d pixels: OpenEXR alone %.2f s; slice %.2f s, ratio %.2f (sampling %.2f); one "
        "file of "
        "parts %.2f s, ratio %.2f\n",
        axis[0], axis[1], axis[2], planes[0].width, planes[0].height, plain, ours, ours / plain,
        sampling / plain, parts, parts / plain);
  }
  std::filesystem::remove_all(folder);
}

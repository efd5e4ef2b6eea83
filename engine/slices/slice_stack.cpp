#include "engine/slices/slice_stack.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

SlicePlanes placeSlices(const std::vector<openvdb::BBoxd>& chartBoxes, int count, double finest) {
  openvdb::BBoxd box;
  for (const auto& b : chartBoxes) box.expand(b);
  const Vec3d extent = box.extents();
  SlicePlanes planes;
  for (int i = 0; i < count; ++i) planes.z0.push_back(box.min()[0] + (i + 0.5) * extent[0] / count);
  constexpr int kPixels = 112;  // across the larger side; chosen by hand
  planes.pixel = std::max(std::max(extent[1], extent[2]) / kPixels, finest);
  planes.nx = int(std::ceil(extent[1] / planes.pixel)) + 5;
  planes.ny = int(std::ceil(extent[2] / planes.pixel)) + 5;
  planes.origin = Vec2d(box.min()[1], box.min()[2]) - Vec2d(2 * planes.pixel);
  return planes;
}

std::vector<SliceImage> sampleSlices(const DistanceField& field, const Chart& chart,
                                     const SlicePlanes& planes) {
  std::vector<SliceImage> images(planes.z0.size());
  const float unit = float(1.0 / chart.meanScale());
  tbb::parallel_for(size_t(0), images.size(), [&](size_t i) {
    DistanceField::Sampler sampler(field);
    SliceImage& image = images[i];
    image.resize(size_t(planes.nx) * planes.ny);
    for (int y = 0; y < planes.ny; ++y)
      for (int x = 0; x < planes.nx; ++x) {
        const Vec3d z(planes.z0[i], planes.origin[0] + x * planes.pixel, planes.origin[1] + y * planes.pixel);
        image[size_t(y) * planes.nx + x] = unit * sampler(field.relative(chart.toWorld(z)));
      }
  });
  return images;
}

}  // namespace slicemorph

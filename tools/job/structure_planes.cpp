#include "tools/job/structure_planes.h"

#include "engine/volume/image_grid.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// One label of a map on any plane: half minus its share, linear between voxels. On the map's own slices it is -0.5 at the
/// label's pixels and 0.5 at the others.
class LabelOnPlane {
 public:
  LabelOnPlane(std::shared_ptr<const Image> image, std::int64_t label, const openvdb::CoordBBox& box)
      : image_(std::move(image)), label_(label), box_(box), voxel_(image_->lattice) {}

  std::vector<float> operator()(const ImagePlane& plane) const {
    const Vec3d first = voxel_(plane.origin);
    const Vec3d step[2] = {voxel_.inverse * plane.step[0], voxel_.inverse * plane.step[1]};
    if (!isNear(first, step, plane)) return {};
    if (isOwn(first, step))
      return std::visit([&](const auto& values) { return copied(values, plane, first); }, image_->values);
    return std::visit([&](const auto& values) { return sampled(values, plane, first, step); },
                      image_->values);
  }

 private:
  static constexpr double kRounding = 1e-4;  ///< of voxels

  /// Whether the plane comes nearer than a voxel to the label's box along the map's axes.
  bool isNear(const Vec3d& first, const Vec3d (&step)[2], const ImagePlane& plane) const {
    for (int d = 0; d < 3; ++d) {
      double low = first[d], high = first[d];
      for (int s = 0; s < 2; ++s) {
        const double reach = step[s][d] * (plane.size[s] - 1);
        low += std::min(reach, 0.0), high += std::max(reach, 0.0);
      }
      if (high < box_.min()[d] - 1 || low > box_.max()[d] + 1) return false;
    }
    return true;
  }

  /// Whether the plane's pixels are voxels of one of the map's slices.
  bool isOwn(const Vec3d& first, const Vec3d (&step)[2]) const {
    constexpr double kPixel = 1e-7;  // of a voxel, from a pixel to the next: 1e-4 over a thousand
    for (int d = 0; d < 3; ++d)
      if (std::abs(first[d] - std::round(first[d])) > kRounding || std::abs(step[0][d] - (d == 0)) > kPixel ||
          std::abs(step[1][d] - (d == 1)) > kPixel)
        return false;
    return true;
  }

  template <typename T>
  std::vector<float> copied(const std::vector<T>& values, const ImagePlane& plane, const Vec3d& first) const {
    const openvdb::Coord at = openvdb::Coord::round(first);
    std::vector<float> result;
    if (at[2] < box_.min()[2] || at[2] > box_.max()[2]) return result;
    result.assign(plane.count(), 0.5f);
    for (int j = std::max(box_.min()[1] - at[1], 0); j <= std::min(box_.max()[1] - at[1], plane.size[1] - 1);
         ++j)
      for (int i = std::max(box_.min()[0] - at[0], 0);
           i <= std::min(box_.max()[0] - at[0], plane.size[0] - 1); ++i)
        if (std::llround(double(values[image_->lattice.index(at[0] + i, at[1] + j, at[2])])) == label_)
          result[size_t(j) * size_t(plane.size[0]) + size_t(i)] = -0.5f;
    return result;
  }

  template <typename T>
  std::vector<float> sampled(const std::vector<T>& values, const ImagePlane& plane, const Vec3d& first,
                             const Vec3d (&step)[2]) const {
    std::vector<float> result(plane.count());
    tbb::parallel_for(0, plane.size[1], [&](int j) {
      for (int i = 0; i < plane.size[0]; ++i)
        result[size_t(j) * size_t(plane.size[0]) + size_t(i)] =
            float(0.5 - shareAt(values, first + double(i) * step[0] + double(j) * step[1]));
    });
    return result;
  }

  /// Share of the label at a position in voxels; nothing lies outside the map. Positions are whole numbers within what
  /// rounding leaves, so that voxels that coincide are exact.
  template <typename T>
  double shareAt(const std::vector<T>& values, const Vec3d& at) const {
    int low[3];
    double part[3];
    for (int d = 0; d < 3; ++d) {
      if (at[d] < box_.min()[d] - 1 || at[d] > box_.max()[d] + 1) return 0;
      low[d] = int(std::floor(at[d] + kRounding)), part[d] = std::max(at[d] - low[d], 0.0);
      if (part[d] < kRounding) part[d] = 0;
    }
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      double weight = 1;
      openvdb::Coord corner;
      for (int d = 0; d < 3; ++d) {
        const int up = c >> d & 1;
        weight *= up ? part[d] : 1 - part[d];
        corner[d] = low[d] + up;
      }
      if (weight > 0 && box_.isInside(corner) &&
          std::llround(double(values[image_->lattice.index(corner[0], corner[1], corner[2])])) == label_)
        sum += weight;
    }
    return sum;
  }

  std::shared_ptr<const Image> image_;
  std::int64_t label_;
  openvdb::CoordBBox box_;
  WorldToVoxel voxel_;
};

/// A level set on any plane: its distances, linear between voxels.
class SurfaceOnPlane {
 public:
  explicit SurfaceOnPlane(FloatGrid::ConstPtr grid) : grid_(std::move(grid)), box_(boxOfGrid(*grid_)) {}

  std::vector<float> operator()(const ImagePlane& plane) const {
    openvdb::BBoxd reach;
    for (const double i : {0, plane.size[0] - 1})
      for (const double j : {0, plane.size[1] - 1}) reach.expand(plane.at(i, j));
    if (!reach.hasOverlap(box_)) return {};
    std::vector<float> result(plane.count());
    tbb::parallel_for(0, plane.size[1], [&](int j) {
      FloatGrid::ConstAccessor accessor = grid_->getConstAccessor();
      for (int i = 0; i < plane.size[0]; ++i)
        result[size_t(j) * size_t(plane.size[0]) + size_t(i)] =
            openvdb::tools::BoxSampler::sample(accessor, grid_->worldToIndex(plane.at(i, j)));
    });
    return result;
  }

 private:
  FloatGrid::ConstPtr grid_;
  openvdb::BBoxd box_;
};

}  // namespace

openvdb::BBoxd boxOfGrid(const FloatGrid& grid) {
  return grid.transform().indexToWorld(grid.evalActiveVoxelBoundingBox());
}

std::function<std::vector<float>(const ImagePlane&)> labelOnPlane(std::shared_ptr<const Image> map,
                                                                  std::int64_t label,
                                                                  const openvdb::CoordBBox& box) {
  return LabelOnPlane(std::move(map), label, box);
}

std::function<std::vector<float>(const ImagePlane&)> surfaceOnPlane(FloatGrid::ConstPtr grid) {
  return SurfaceOnPlane(std::move(grid));
}

}  // namespace slicemorph

#include "engine/slices/section.h"

#include "engine/errors.h"
#include "engine/frame/moments.h"

#include <openvdb/tools/Interpolation.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace slicemorph {
namespace {

constexpr double kMarginPixels = 3;

bool isLevelSet(const FloatGrid& grid) { return grid.getGridClass() == openvdb::GRID_LEVEL_SET; }

/// Linear part of a grid's transform: world direction = jacobian * index direction.
Mat3d jacobianOf(const FloatGrid& grid) {
  Mat3d jacobian;
  for (int a = 0; a < 3; ++a) {
    Vec3d unit(0.0);
    unit[a] = 1;
    jacobian.setCol(
        a, grid.transform().baseMap()->applyMap(unit) - grid.transform().baseMap()->applyMap(Vec3d(0.0)));
  }
  return jacobian;
}

/// Sums over the voxels of the object, index space.
struct VoxelSums {
  double weight = 0;
  Vec3d first{0, 0, 0};
  Mat3d second = Mat3d::zero();
};

/// `box`: a voxel or a tile.
void add(VoxelSums& sum, const openvdb::CoordBBox& box) {
  const Vec3d dim = box.dim().asVec3d();
  const double weight = dim.x() * dim.y() * dim.z();
  const Vec3d centre = (box.min().asVec3d() + box.max().asVec3d()) / 2;
  sum.weight += weight;
  sum.first += weight * centre;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) sum.second(r, c) += weight * centre[r] * centre[c];
    sum.second(r, r) += weight * dim[r] * dim[r] / 12;
  }
}

/// A level set's inside, in the band or not; else the active voxels. In the tree's order: the sums are the
/// same always.
VoxelSums sumsOf(const FloatGrid& grid) {
  VoxelSums sum;
  if (isLevelSet(grid)) {
    for (auto it = grid.cbeginValueAll(); it; ++it) {
      if (*it < 0) add(sum, it.getBoundingBox());
    }
  } else {
    for (auto it = grid.cbeginValueOn(); it; ++it) add(sum, it.getBoundingBox());
  }
  return sum;
}

/// Covariance of the object in world space.
Mat3d covarianceOf(const FloatGrid& grid, const VoxelSums& sums) {
  const Vec3d mean = sums.first / sums.weight;
  Mat3d covariance = sums.second * (1 / sums.weight);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) covariance(r, c) -= mean[r] * mean[c];
  }
  const Mat3d jacobian = jacobianOf(grid);
  return jacobian * covariance * jacobian.transpose();
}

/// Of the two directions of an axis, the one whose largest component is positive.
Vec3d directed(const Vec3d& axis) {
  const Vec3d size = openvdb::math::Abs(axis);
  const int largest = size[0] >= size[1] && size[0] >= size[2] ? 0 : (size[1] >= size[2] ? 1 : 2);
  return axis[largest] < 0 ? -axis : axis;
}

/// The world axis that is farthest from `normal`, made orthogonal to it.
Vec3d acrossOf(const Vec3d& normal) {
  const Vec3d size = openvdb::math::Abs(normal);
  Vec3d axis(0.0);
  axis[size[0] <= size[1] && size[0] <= size[2] ? 0 : (size[1] <= size[2] ? 1 : 2)] = 1;
  return (axis - normal * axis.dot(normal)).unit();
}

/// In-plane axes and normal as columns.
Mat3d planeAxes(const FloatGrid& grid, const Vec3d& wanted, const VoxelSums& sums) {
  Vec3d normal, across;
  if (wanted.lengthSqr() > 0) {
    normal = wanted.unit();
    across = acrossOf(normal);
  } else {
    const Mat3d axes = principalAxes(covarianceOf(grid, sums)).axes;
    normal = directed(axes.col(0));
    across = directed(axes.col(1));
  }
  Mat3d frame;
  frame.setCol(0, across);
  frame.setCol(1, normal.cross(across));
  frame.setCol(2, normal);
  return frame;
}

/// The object's extent along the columns of `frame`, world units.
struct Extents {
  Vec3d lo{std::numeric_limits<double>::max()}, hi{-std::numeric_limits<double>::max()};
};

Extents extentsAlong(const FloatGrid& grid, const Mat3d& frame) {
  // Each extent is a linear function of the index position; a voxel reaches half of |coefficients| to both
  // sides.
  const Mat3d linear = frame.transpose() * jacobianOf(grid);
  const Vec3d offset = frame.transpose() * grid.indexToWorld(Vec3d(0.0));
  const bool levelSet = isLevelSet(grid);
  Extents extents;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    if (levelSet && *it >= 0) continue;
    const openvdb::CoordBBox box = it.getBoundingBox();
    const Vec3d half = box.dim().asVec3d() / 2;
    const Vec3d centre = linear * ((box.min().asVec3d() + box.max().asVec3d()) / 2) + offset;
    Vec3d reach;
    for (int a = 0; a < 3; ++a) reach[a] = openvdb::math::Abs(linear.row(a)).dot(half);
    extents.lo = openvdb::math::minComponent(extents.lo, centre - reach);
    extents.hi = openvdb::math::maxComponent(extents.hi, centre + reach);
  }
  return extents;
}

void check(const FloatGrid& grid, const SectionOptions& options) {
  if (options.count < 1 || options.count > 100000) {
    throw InputError("slices " + std::to_string(options.count) + ": must be 1 to 100000");
  }
  if (!(options.pixelSize >= 0) || !std::isfinite(options.pixelSize)) {
    throw InputError("pixel size " + std::to_string(options.pixelSize) + ": must be above 0");
  }
  if (!std::isfinite(options.axis.lengthSqr()))
    throw InputError("slicing axis: must be three finite numbers");
  if (!grid.transform().isLinear()) {
    throw InputError("grid \"" + grid.getName() +
                     "\" has a frustum transform; only linear ones can be sliced");
  }
}

}  // namespace

std::vector<SectionPlane> sectionPlanes(const FloatGrid& grid, const SectionOptions& options) {
  check(grid, options);
  const VoxelSums sums = sumsOf(grid);
  if (!(sums.weight > 0))
    throw GeometryError("grid \"" + grid.getName() + "\" is empty: there is nothing to slice");
  const Mat3d frame = planeAxes(grid, options.axis, sums);
  const Extents extents = extentsAlong(grid, frame);
  if (extents.lo.x() > extents.hi.x()) {
    throw GeometryError("grid \"" + grid.getName() +
                        "\" has no active voxels inside its surface: there is nothing to slice");
  }
  const Vec3d voxel = grid.voxelSize();
  const double pixel =
      options.pixelSize > 0 ? options.pixelSize : std::min({voxel.x(), voxel.y(), voxel.z()});
  const Vec3d middle = (extents.lo + extents.hi) / 2, size = extents.hi - extents.lo;
  const double across = std::ceil(size.x() / pixel) + 2 * kMarginPixels,
               down = std::ceil(size.y() / pixel) + 2 * kMarginPixels;
  if (across * down > double(1 << 28)) {
    throw InputError("pixel size " + std::to_string(pixel) +
                     ": a slice would have more than 2^28 pixels; choose a larger one");
  }

  std::vector<SectionPlane> planes(options.count);
  for (int n = 0; n < options.count; ++n) {
    SectionPlane& plane = planes[n];
    plane.index = n;
    plane.count = options.count;
    plane.u = (2.0 * n + 1) / options.count - 1;
    plane.xAxis = frame.col(0);
    plane.yAxis = frame.col(1);
    plane.normal = frame.col(2);
    plane.pixelSize = pixel;
    plane.width = int(across);
    plane.height = int(down);
    plane.origin = frame * Vec3d(middle.x() - pixel * (across - 1) / 2, middle.y() - pixel * (down - 1) / 2,
                                 middle.z() + plane.u * size.z() / 2);
  }
  return planes;
}

Section sampleSection(const FloatGrid& grid, const SectionPlane& plane) {
  Section section{plane, std::vector<float>(size_t(plane.width) * plane.height)};
  const auto accessor = grid.getConstAccessor();
  // The transform is linear: step in index space.
  const Vec3d origin = grid.worldToIndex(plane.origin);
  const Vec3d right = grid.worldToIndex(plane.origin + plane.xAxis * plane.pixelSize) - origin;
  const Vec3d down = grid.worldToIndex(plane.origin + plane.yAxis * plane.pixelSize) - origin;
  float* value = section.values.data();
  for (int j = 0; j < plane.height; ++j) {
    for (int i = 0; i < plane.width; ++i) {
      *value++ = openvdb::tools::BoxSampler::sample(accessor, origin + right * double(i) + down * double(j));
    }
  }
  return section;
}

std::vector<Section> sections(const FloatGrid& grid, const SectionOptions& options) {
  const std::vector<SectionPlane> planes = sectionPlanes(grid, options);
  std::vector<Section> result(planes.size());
  tbb::parallel_for(size_t(0), planes.size(), [&](size_t n) { result[n] = sampleSection(grid, planes[n]); });
  return result;
}

}  // namespace slicemorph

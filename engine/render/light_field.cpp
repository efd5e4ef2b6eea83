#include "engine/render/light_field.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

/// Largest number of nodes along the longest side: limits the lattice to about 4 million nodes (16 MB).
constexpr double kFinest = 160;

float arriving(double opticalDepth) {
  double sum = 0, most = 0;
  for (const double share : {1.0, 0.5, 0.25}) {
    sum += share * std::exp(-share * opticalDepth);
    most += share;
  }
  return float(sum / most);
}

}  // namespace

LightField::LightField(const FloatGrid& density, const Vec3d& towards, double extinction) {
  axes_[2] = -towards;
  axes_[0] = towards.cross(std::abs(towards.x()) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).unit();
  axes_[1] = towards.cross(axes_[0]);
  const openvdb::CoordBBox active = density.evalActiveVoxelBoundingBox();
  Vec3d lo(std::numeric_limits<double>::max()), hi(-std::numeric_limits<double>::max());
  for (int n = 0; n < 8; ++n) {
    const Vec3d corner((n & 1 ? active.max() : active.min()).x(), (n & 2 ? active.max() : active.min()).y(),
                       (n & 4 ? active.max() : active.min()).z());
    const Vec3d world = density.indexToWorld(corner);
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], world.dot(axes_[a]));
      hi[a] = std::max(hi[a], world.dot(axes_[a]));
    }
  }
  const Vec3d voxel = density.voxelSize(), extent = hi - lo;
  spacing_ = std::max(std::min({voxel[0], voxel[1], voxel[2]}),
                      std::max({extent[0], extent[1], extent[2]}) / kFinest);
  origin_ = lo;
  // One extra node, so that every position in the fog is in a cell of eight.
  for (int a = 0; a < 3; ++a) size_[a] = int(std::ceil(extent[a] / spacing_)) + 2;
  light_.resize(size_t(size_[0]) * size_t(size_[1]) * size_t(size_[2]));
  tbb::parallel_for(tbb::blocked_range2d<int>(0, size_[0], 8, 0, size_[1], 8), [&](const auto& range) {
    const auto accessor = density.getConstAccessor();
    for (int i = range.rows().begin(); i < range.rows().end(); ++i) {
      for (int j = range.cols().begin(); j < range.cols().end(); ++j) {
        float* column = &light_[(size_t(i) * size_t(size_[1]) + size_t(j)) * size_t(size_[2])];
        double passed = 0;  // optical depth so far
        for (int k = 0; k < size_[2]; ++k) {
          const Vec3d along = origin_ + Vec3d(i, j, k) * spacing_;
          const Vec3d world = axes_[0] * along[0] + axes_[1] * along[1] + axes_[2] * along[2];
          const double here =
              std::max(0.0f, openvdb::tools::BoxSampler::sample(accessor, density.worldToIndex(world)));
          const double half = 0.5 * here * extinction * spacing_;
          column[k] = arriving(passed + half);
          passed += 2 * half;
        }
      }
    }
  });
}

float LightField::at(const Vec3d& world) const {
  int first[3];
  float part[3];
  for (int a = 0; a < 3; ++a) {
    const double at = std::clamp((world.dot(axes_[a]) - origin_[a]) / spacing_, 0.0, size_[a] - 1.000001);
    first[a] = int(at);
    part[a] = float(at - first[a]);
  }
  const float* corner =
      &light_[(size_t(first[0]) * size_t(size_[1]) + size_t(first[1])) * size_t(size_[2]) + size_t(first[2])];
  const size_t toJ = size_t(size_[2]), toI = toJ * size_t(size_[1]);
  const auto along = [&](size_t offset) {
    return corner[offset] + (corner[offset + 1] - corner[offset]) * part[2];
  };
  const float near = along(0) + (along(toJ) - along(0)) * part[1];
  const float far = along(toI) + (along(toI + toJ) - along(toI)) * part[1];
  return near + (far - near) * part[0];
}

}  // namespace slicemorph

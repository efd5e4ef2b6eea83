#include "engine/sections/section.h"

#include "engine/sections/object_boxes.h"
#include "slicemorph/errors.h"

#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>

namespace slicemorph {
namespace {

using openvdb::Coord;

/// Trilinear sampler for consecutive points, most of which are in the same leaf as the one before.
template <typename Tree>
class LinearSampler {
 public:
  using Value = typename Tree::ValueType;
  explicit LinearSampler(const Tree& tree) : accessor_(tree) {}

  Value operator()(const Vec3d& p) {
    int in[3];  // first of the eight voxels, relative to its leaf
    double share[3];
    Coord leaf;
    for (int a = 0; a < 3; ++a) {
      // std::floor is a function call unless the compiler may use SSE 4.1.
      const int towardsZero = int(p[a]), base = towardsZero - (p[a] < towardsZero);
      in[a] = base & kMask, leaf[a] = base & ~kMask;
      share[a] = p[a] - base;
    }
    if (leaf != leaf_ || !entered_) enter(leaf);
    const double yz = share[1] * share[2], xz = share[0] * share[2], xy = share[0] * share[1],
                 xyz = xy * share[2];
    const double weight[8] = {
        // the first value itself: differences from it are weighted, so that constants are reproduced exactly
        0,
        share[2] - xz - yz + xyz,
        share[1] - xy - yz + xyz,
        yz - xyz,
        share[0] - xy - xz + xyz,
        xz - xyz,
        xy - xyz,
        xyz};
    if (in[0] < kMask && in[1] < kMask && in[2] < kMask) {
      const int step = step_[0];
      const Number* from = values_[0] + step * (in[0] * kX + in[1] * kY + in[2] * kZ);
      const int x = step * kX, y = step * kY, z = step * kZ;
      return sum(weight, {from, from + z, from + y, from + y + z, from + x, from + x + z, from + x + y,
                          from + x + y + z});
    }
    const auto at = [&](int n) {
      const int voxel[3] = {in[0] + (n >> 2), in[1] + (n >> 1 & 1), in[2] + (n & 1)};
      const int leaf = (voxel[0] >> kLog) << 2 | (voxel[1] >> kLog) << 1 | voxel[2] >> kLog;
      if ((found_ >> leaf & 1) == 0) find(leaf);
      return values_[leaf] +
             step_[leaf] * ((voxel[0] & kMask) * kX + (voxel[1] & kMask) * kY + (voxel[2] & kMask) * kZ);
    };
    return sum(weight, {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)});
  }

 private:
  using Leaf = typename Tree::LeafNodeType;
  using Number = typename openvdb::VecTraits<Value>::ElementType;
  static constexpr int kCount = openvdb::VecTraits<Value>::Size;
  static constexpr int kLog = int(Leaf::LOG2DIM), kSide = int(Leaf::DIM), kMask = kSide - 1;
  /// offsets to the next voxel, in numbers
  static constexpr int kZ = kCount, kY = kSide * kZ, kX = kSide * kY;

  static Value sum(const double (&weight)[8], const Number* const (&at)[8]) {
    Number result[kCount];
    for (int c = 0; c < kCount; ++c) {
      const double from = at[0][c];
      const auto part = [&](int n) { return weight[n] * (at[n][c] - from); };
      result[c] =
          Number(from + ((part(1) + (part(2) + part(3))) + ((part(4) + part(5)) + (part(6) + part(7)))));
    }
    if constexpr (kCount == 1)
      return result[0];
    else
      return Value(result);
  }

  void enter(const Coord& leaf) {
    entered_ = true;
    leaf_ = leaf;
    found_ = 0;
    find(0);
  }
  void find(int n) {
    found_ |= 1 << n;
    const Coord origin = leaf_.offsetBy((n >> 2) * kSide, (n >> 1 & 1) * kSide, (n & 1) * kSide);
    const Leaf* leaf = accessor_.probeConstLeaf(origin);
    step_[n] = leaf ? 1 : 0;
    if (!leaf) tile_[n] = accessor_.getValue(origin);
    values_[n] = reinterpret_cast<const Number*>(leaf ? leaf->buffer().data() : &tile_[n]);
  }

  openvdb::tree::ValueAccessor<const Tree> accessor_;
  bool entered_ = false;
  int found_ = 0;  ///< bit set: which of the eight leaves are known
  Coord leaf_;     ///< first voxel of the leaf
  /// Of the leaf and its seven upper neighbours: the first value, and the number of values to skip per voxel
  /// (0 for a tile, which has one value only).
  const Number* values_[8];
  int step_[8];
  Value tile_[8];
};

/// Index-space positions of a slice's pixels, for a linear transform.
struct Steps {
  Vec3d origin, right, down;
  Steps(const openvdb::GridBase& grid, const SectionPlane& plane)
      : origin(grid.worldToIndex(plane.origin)),
        right(grid.worldToIndex(plane.toWorld(1, 0)) - origin),
        down(grid.worldToIndex(plane.toWorld(0, 1)) - origin) {}
  Vec3d at(int i, int j) const { return origin + right * double(i) + down * double(j); }
};

/// Visits the pixels of several slices block by block, and within a block slice by slice, so that consecutive
/// pixels are mostly in the same leaves. Calls `sample(index position, slice, pixel)`.
template <typename Sample>
void forPixels(const openvdb::GridBase& grid, const std::vector<SectionPlane>& planes, const Sample& sample) {
  constexpr int kBlock = 16;  // pixels along a side
  std::vector<Steps> steps;
  int width = 0, height = 0;
  for (const SectionPlane& plane : planes) {
    steps.emplace_back(grid, plane);
    width = std::max(width, plane.width), height = std::max(height, plane.height);
  }
  for (int top = 0; top < height; top += kBlock)
    for (int left = 0; left < width; left += kBlock)
      for (size_t n = 0; n < planes.size(); ++n)
        for (int j = top; j < std::min(top + kBlock, planes[n].height); ++j)
          for (int i = left; i < std::min(left + kBlock, planes[n].width); ++i)
            sample(steps[n].at(i, j), n, size_t(j) * size_t(planes[n].width) + size_t(i));
}

/// Integers are stored as floats, which hold them exactly up to 2^24 only. Throws InputError beyond.
void checkExact(const openvdb::GridBase& grid, double value) {
  constexpr double kLargest = 1 << 24;  // the significand of a float has 24 bits
  if (std::abs(value) > kLargest)
    throw InputError(
        "grid '" + grid.getName() + "' holds " + std::to_string(std::int64_t(value)) +
        ", and float channels hold whole numbers only up to 16777216; leave it out with --grids");
}

template <typename Grid>
void sampleGrid(const Grid& grid, const std::vector<SectionPlane>& planes,
                std::vector<SectionValues>& results) {
  using Value = typename Grid::ValueType;
  const auto put = [&](size_t slice, size_t pixel, const auto& value) {
    SectionValues& result = results[slice];
    if constexpr (openvdb::VecTraits<Value>::IsVec) {
      const size_t count = result.values.size() / 3;
      for (int c = 0; c < 3; ++c) result.values[size_t(c) * count + pixel] = float(value[c]);
    } else {
      result.values[pixel] = float(value);
    }
  };
  using Number = typename openvdb::VecTraits<Value>::ElementType;
  if constexpr (std::is_floating_point_v<Number>) {
    LinearSampler<typename Grid::TreeType> sampler(grid.tree());
    if (!openvdb::VecTraits<Value>::IsVec || grid.getGridClass() != openvdb::GRID_STAGGERED)
      return forPixels(grid, planes, [&](const Vec3d& p, size_t n, size_t i) { put(n, i, sampler(p)); });
    // Component c of a voxel is located on its lower face along axis c.
    if constexpr (openvdb::VecTraits<Value>::IsVec)
      for (int c = 0; c < 3; ++c) {
        Vec3d face(0.0);
        face[c] = 0.5;
        forPixels(grid, planes, [&](const Vec3d& p, size_t n, size_t i) {
          results[n].values[size_t(c) * results[n].values.size() / 3 + i] = float(sampler(p + face)[c]);
        });
      }
  } else {
    const auto accessor = grid.getConstAccessor();
    forPixels(grid, planes, [&](const Vec3d& p, size_t n, size_t i) {
      const auto value = accessor.getValue(Coord::round(p));
      if constexpr (!openvdb::VecTraits<Value>::IsVec && sizeof(value) > 2) checkExact(grid, double(value));
      put(n, i, value);
    });
  }
}

}  // namespace

std::vector<SectionValues> sampleSections(const openvdb::GridBase& grid,
                                          const std::vector<SectionPlane>& planes) {
  std::vector<SectionValues> results(planes.size());
  const bool known = grid.apply<SliceableTypes>([&](const auto& typed) {
    using Value = typename std::decay_t<decltype(typed)>::ValueType;
    for (size_t n = 0; n < planes.size(); ++n) {
      results[n].components = openvdb::VecTraits<Value>::IsVec ? 3 : 1;
      results[n].values.resize(size_t(results[n].components) * size_t(planes[n].width) *
                               size_t(planes[n].height));
    }
    sampleGrid(typed, planes, results);
  });
  if (!known)
    throw InputError("grid '" + grid.getName() + "' holds " + grid.valueType() +
                     " values, which cannot be sliced");
  return results;
}

SectionValues sampleSection(const openvdb::GridBase& grid, const SectionPlane& plane) {
  return sampleSections(grid, {plane})[0];
}

}  // namespace slicemorph

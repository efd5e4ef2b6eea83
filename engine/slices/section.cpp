#include "engine/slices/section.h"

#include "engine/errors.h"
#include "engine/slices/object_boxes.h"

#include <openvdb/tools/Interpolation.h>

#include <cmath>
#include <type_traits>

namespace slicemorph {
namespace {

using openvdb::Coord;

/// Trilinear values at places that follow each other: most lie in the leaf of the one before.
template <typename Tree>
class LinearSampler {
 public:
  using Value = typename Tree::ValueType;
  explicit LinearSampler(const Tree& tree) : accessor_(tree) {}

  Value operator()(const Vec3d& p) {
    const Coord base = Coord::floor(p);
    const Vec3d between = p - base.asVec3d();
    constexpr int kMask = int(Leaf::DIM) - 1;
    const Coord in = base & kMask;
    Value v[2][2][2];
    if (in[0] < kMask && in[1] < kMask && in[2] < kMask) {
      enter(base - in);
      if (!values_) return tile_;
      constexpr int kX = int(Leaf::DIM * Leaf::DIM), kY = int(Leaf::DIM);
      const Value* from = values_ + in[0] * kX + in[1] * kY + in[2];
      for (int n = 0; n < 8; ++n)
        v[n >> 2][n >> 1 & 1][n & 1] = from[(n >> 2) * kX + (n >> 1 & 1) * kY + (n & 1)];
    } else {
      openvdb::tools::BoxSampler::getValues(v, accessor_, base);
    }
    return openvdb::tools::BoxSampler::trilinearInterpolation(v, between);
  }

 private:
  using Leaf = typename Tree::LeafNodeType;
  void enter(const Coord& origin) {
    if (entered_ && origin == origin_) return;
    entered_ = true;
    origin_ = origin;
    const Leaf* leaf = accessor_.probeConstLeaf(origin);
    values_ = leaf ? leaf->buffer().data() : nullptr;
    if (!leaf) tile_ = accessor_.getValue(origin);
  }

  openvdb::tree::ValueAccessor<const Tree> accessor_;
  bool entered_ = false;
  Coord origin_;
  const Value* values_ = nullptr;  ///< of the leaf; null: a tile
  Value tile_ = openvdb::zeroVal<Value>();
};

/// Index positions of a slice's pixels; the transform is linear.
struct Steps {
  Vec3d origin, right, down;
  Steps(const openvdb::GridBase& grid, const SectionPlane& plane)
      : origin(grid.worldToIndex(plane.origin)),
        right(grid.worldToIndex(plane.toWorld(1, 0)) - origin),
        down(grid.worldToIndex(plane.toWorld(0, 1)) - origin) {}
  Vec3d at(int i, int j) const { return origin + right * double(i) + down * double(j); }
};

template <typename Sample>
void fill(const SectionPlane& plane, const Steps& steps, const Sample& sample, float* to) {
  for (int j = 0; j < plane.height; ++j)
    for (int i = 0; i < plane.width; ++i) sample(steps.at(i, j), to++);
}

template <typename Grid>
void sampleGrid(const Grid& grid, const SectionPlane& plane, const Steps& steps, SectionValues& result) {
  using Value = typename Grid::ValueType;
  const size_t count = size_t(plane.width) * size_t(plane.height);
  float* to = result.values.data();
  if constexpr (std::is_floating_point_v<Value>) {
    LinearSampler<typename Grid::TreeType> sampler(grid.tree());
    fill(
        plane, steps, [&](const Vec3d& p, float* v) { *v = float(sampler(p)); }, to);
  } else if constexpr (openvdb::VecTraits<Value>::IsVec &&
                       !std::is_integral_v<typename openvdb::VecTraits<Value>::ElementType>) {
    LinearSampler<typename Grid::TreeType> sampler(grid.tree());
    if (grid.getGridClass() != openvdb::GRID_STAGGERED) {
      fill(
          plane, steps,
          [&](const Vec3d& p, float* v) {
            const Value value = sampler(p);
            for (int c = 0; c < 3; ++c) v[size_t(c) * count] = float(value[c]);
          },
          to);
      return;
    }
    // Component c of a voxel is on its lower face across axis c.
    for (int c = 0; c < 3; ++c) {
      Vec3d face(0.0);
      face[c] = 0.5;
      fill(
          plane, steps, [&](const Vec3d& p, float* v) { *v = float(sampler(p + face)[c]); },
          to + size_t(c) * count);
    }
  } else {
    const auto accessor = grid.getConstAccessor();
    fill(
        plane, steps,
        [&](const Vec3d& p, float* v) {
          const auto value = accessor.getValue(Coord::round(p));
          if constexpr (openvdb::VecTraits<Value>::IsVec)
            for (int c = 0; c < 3; ++c) v[size_t(c) * count] = float(value[c]);
          else
            *v = float(value);
        },
        to);
  }
}

}  // namespace

SectionValues sampleSection(const openvdb::GridBase& grid, const SectionPlane& plane) {
  SectionValues result;
  const Steps steps(grid, plane);
  const bool known = grid.apply<SliceableTypes>([&](const auto& typed) {
    using Value = typename std::decay_t<decltype(typed)>::ValueType;
    result.components = openvdb::VecTraits<Value>::IsVec ? 3 : 1;
    result.values.resize(size_t(result.components) * size_t(plane.width) * size_t(plane.height));
    sampleGrid(typed, plane, steps, result);
  });
  if (!known)
    throw InputError("grid '" + grid.getName() + "' holds " + grid.valueType() +
                     " values, which cannot be sliced");
  return result;
}

}  // namespace slicemorph

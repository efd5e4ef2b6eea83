#include "engine/reconstruct/sections_to_grid.h"

#include "engine/rebuild/redistance.h"
#include "engine/rebuild/sweep_band.h"
#include "engine/reconstruct/section_slabs.h"
#include "engine/sections/object_boxes.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <type_traits>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::GridBase;

constexpr double kMostLeaves = double(1 << 24);  // 2^33 voxels
/// The share of the slices' band that holds true distances: where it was sampled, its outermost voxel is
/// partly clamped. Two of three voxels.
constexpr double kTrusted = 2.0 / 3;

bool isLevelSet(const GridBase& prototype) {
  return prototype.getGridClass() == openvdb::GRID_LEVEL_SET &&
         (prototype.isType<FloatGrid>() || prototype.isType<openvdb::DoubleGrid>());
}

double backgroundOf(const GridBase& prototype) {
  double background = 0;
  prototype.apply<openvdb::TypeList<FloatGrid, openvdb::DoubleGrid>>(
      [&](const auto& g) { background = double(g.background()); });
  return background;
}

/// Weights of the values at -1, 0, 1, 2 [CR74].
std::array<float, 4> catmullRom(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {(-t3 + 2 * t2 - t) / 2, (3 * t3 - 5 * t2 + 2) / 2, (-3 * t3 + 4 * t2 + t) / 2, (t3 - t2) / 2};
}

/// One component of one slice; the background outside its pixels.
struct Picture {
  const SectionPlane* plane;
  const float* values;
  float background;

  float at(int i, int j) const {
    const bool in = i >= 0 && j >= 0 && i < plane->width && j < plane->height;
    return in ? values[size_t(j) * size_t(plane->width) + size_t(i)] : background;
  }
  float linear(const Vec3d& p) const {
    const int i = int(std::floor(p[0])), j = int(std::floor(p[1]));
    const float x = float(p[0] - i), y = float(p[1] - j);
    const float above = at(i, j) + x * (at(i + 1, j) - at(i, j));
    const float below = at(i, j + 1) + x * (at(i + 1, j + 1) - at(i, j + 1));
    return above + y * (below - above);
  }
  /// Catmull-Rom spline, which preserves curvature between the pixels.
  float cubic(const Vec3d& p) const {
    const int i = int(std::floor(p[0])), j = int(std::floor(p[1]));
    const std::array<float, 4> across = catmullRom(float(p[0] - i)), down = catmullRom(float(p[1] - j));
    float sum = 0;
    for (int y = 0; y < 4; ++y) {
      float row = 0;
      for (int x = 0; x < 4; ++x) row += across[size_t(x)] * at(i + x - 1, j + y - 1);
      sum += down[size_t(y)] * row;
    }
    return sum;
  }
  float nearest(const Vec3d& p) const { return at(int(std::floor(p[0] + 0.5)), int(std::floor(p[1] + 0.5))); }
};

/// Whether the planes are parallel and evenly spaced.
bool areEven(const std::vector<SectionPlane>& planes) {
  for (size_t n = 1; n < planes.size(); ++n) {
    const double gap = planes[0].distance(planes[1].origin), here = planes[n - 1].distance(planes[n].origin);
    if (planes[n].normal.dot(planes[0].normal) < 1 - 1e-9 || std::abs(here - gap) > 1e-3 * std::abs(gap))
      return false;
  }
  return true;
}

/// The slices of one grid as a function in space.
class Field {
 public:
  Field(const std::vector<SectionPlane>& planes, const SlicedGrid& sliced, const Vec3d& background,
        bool whole, bool distance, double reach)
      : planes_(planes),
        sliced_(sliced),
        background_(background),
        whole_(whole),
        distance_(distance),
        evenly_(areEven(planes)),
        slabs_(planes, reach) {}

  const SectionSlabs& slabs() const { return slabs_; }

  float value(const Vec3d& world, int component, const std::vector<size_t>& near) const {
    BetweenSections position;
    const float background = float(background_[component]);
    if (!slabs_.find(world, near, position)) return background;
    const Picture a = picture(position.slab, component, background),
                  b = picture(position.slab + 1, component, background);
    if (distance_) {
      const float first = a.cubic(position.first), second = b.cubic(position.second);
      // Beyond the end slices the distances continue, up to a flat cap half a gap away.
      float on = first + float(position.share) * (second - first);
      if (evenly_ && position.slab > 0 && position.slab + 2 < planes_.size() && position.beyond < 0) {
        const float before =
            picture(position.slab - 1, component, background).cubic(onPlane(position.slab - 1, world));
        const float after =
            picture(position.slab + 2, component, background).cubic(onPlane(position.slab + 2, world));
        const std::array<float, 4> w = catmullRom(float(position.share));
        on = w[0] * before + w[1] * first + w[2] * second + w[3] * after;
      }
      return std::clamp(std::max(on, float(position.beyond)), -background, background);
    }
    if (position.beyond > 0) return background;
    if (whole_) return position.share < 0.5 ? a.nearest(position.first) : b.nearest(position.second);
    const float share = float(std::clamp(position.share, 0.0, 1.0));
    const float first = a.linear(position.first), second = b.linear(position.second);
    return first + share * (second - first);
  }

 private:
  /// Pixel coordinates of a world point's projection onto a plane.
  Vec3d onPlane(size_t n, const Vec3d& world) const {
    const SectionPlane& plane = planes_[n];
    const Vec3d d = (world - plane.origin) / plane.pixelSize;
    return {d.dot(plane.xAxis), d.dot(plane.yAxis), 0};
  }
  Picture picture(size_t n, int component, float background) const {
    const SectionPlane& plane = planes_[n];
    const size_t count = size_t(plane.width) * size_t(plane.height);
    return {&plane, sliced_.slices[n].values.data() + size_t(component) * count, background};
  }

  const std::vector<SectionPlane>& planes_;
  const SlicedGrid& sliced_;
  Vec3d background_;
  bool whole_, distance_, evenly_;
  SectionSlabs slabs_;
};

/// Origins of all leaves that a world box touches.
std::vector<Coord> leavesOf(const openvdb::BBoxd& box, double voxelSize) {
  const Vec3d lo = box.min() / (voxelSize * kLeaf), hi = box.max() / (voxelSize * kLeaf),
              n = hi - lo + Vec3d(1);
  if (!(n[0] * n[1] * n[2] < kMostLeaves) || openvdb::math::Abs(lo).length() > 1e8)
    throw InputError("voxel size " + std::to_string(voxelSize) +
                     ": the volume between the slices would have more than 2^33 voxels; choose a larger one");
  std::vector<Coord> origins;
  for (int x = int(std::floor(lo[0])); x <= int(std::floor(hi[0])); ++x)
    for (int y = int(std::floor(lo[1])); y <= int(std::floor(hi[1])); ++y)
      for (int z = int(std::floor(lo[2])); z <= int(std::floor(hi[2])); ++z)
        origins.emplace_back(x * kLeaf, y * kLeaf, z * kLeaf);
  return origins;
}

/// Calls visit(leaf, slabs near it) in parallel, for leaves with slabs near them.
template <typename Visit>
void forLeaves(const std::vector<Coord>& origins, const SectionSlabs& slabs, double h, const Visit& visit) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, origins.size()),
                    [&](const tbb::blocked_range<size_t>& range) {
                      std::vector<size_t> near;
                      for (size_t n = range.begin(); n < range.end(); ++n) {
                        slabs.near(h * (origins[n].asVec3d() + Vec3d(0.5 * (kLeaf - 1))),
                                   h * kLeaf * 0.5 * std::sqrt(3.0), near);
                        if (!near.empty()) visit(n, near);
                      }
                    });
}

Vec3d worldOf(const Coord& origin, int n, double h) {
  return h * origin.offsetBy(n / (kLeaf * kLeaf), n / kLeaf % kLeaf, n % kLeaf).asVec3d();
}

FloatGrid::Ptr levelSetOf(const Field& field, const openvdb::math::Transform& transform, double h,
                          double band) {
  const std::vector<Coord> origins = leavesOf(field.slabs().box(), h);
  using Block = std::array<float, kLeafSize>;
  std::vector<std::unique_ptr<Block>> blocks(origins.size());
  const float trusted = float(kTrusted * band);
  forLeaves(origins, field.slabs(), h, [&](size_t leaf, const std::vector<size_t>& near) {
    auto block = std::make_unique<Block>();
    bool any = false;
    for (int n = 0; n < kLeafSize; ++n) {
      const float v = field.value(worldOf(origins[leaf], n, h), 0, near);
      const bool known = std::abs(v) < trusted;
      (*block)[size_t(n)] = known ? v : SparseValues::kUnknown;
      any = any || known;
    }
    if (any) blocks[leaf] = std::move(block);
  });
  std::vector<Coord> kept;
  for (size_t n = 0; n < blocks.size(); ++n)
    if (blocks[n]) kept.push_back(origins[n]);
  SparseValues values(std::move(kept), float(h));
  size_t at = 0;
  for (const auto& block : blocks)
    if (block) std::copy(block->begin(), block->end(), values.leaf(at++));
  const FloatGrid::Ptr narrow = redistance(values, transform);
  if (narrow->empty()) return narrow;
  return widenedLevelSet(*narrow, int(kHalfWidth), float(kHalfWidth * h));
}

template <typename Grid>
void fillGrid(Grid& grid, const Field& field, double h) {
  using Tree = typename Grid::TreeType;
  using Leaf = typename Tree::LeafNodeType;
  using Value = typename Grid::ValueType;
  const std::vector<Coord> origins = leavesOf(field.slabs().box(), h);
  std::vector<std::unique_ptr<Leaf>> leaves(origins.size());
  const Value background = grid.background();
  const double face = grid.getGridClass() == openvdb::GRID_STAGGERED ? 0.5 : 0;
  forLeaves(origins, field.slabs(), h, [&](size_t n, const std::vector<size_t>& near) {
    auto leaf = std::make_unique<Leaf>(origins[n], background);
    for (int i = 0; i < kLeafSize; ++i) {
      const Vec3d world = worldOf(origins[n], i, h);
      Value value;
      if constexpr (openvdb::VecTraits<Value>::IsVec) {
        for (int c = 0; c < 3; ++c) {
          Vec3d position = world;
          position[c] -= face * h;
          value[c] = typename Value::value_type(field.value(position, c, near));
        }
      } else if constexpr (std::is_same_v<Value, bool>) {
        value = field.value(world, 0, near) > 0.5f;
      } else {
        value = Value(field.value(world, 0, near));
      }
      if (value != background) leaf->setValueOn(openvdb::Index(i), value);
    }
    if (!leaf->isEmpty()) leaves[n] = std::move(leaf);
  });
  for (auto& leaf : leaves)
    if (leaf) grid.tree().addLeaf(leaf.release());
}

}  // namespace

std::vector<size_t> orderOfSections(const std::vector<SectionPlane>& planes) {
  std::vector<size_t> order(planes.size());
  std::iota(order.begin(), order.end(), size_t(0));
  const bool parallel = std::all_of(planes.begin(), planes.end(), [&](const SectionPlane& plane) {
    return std::abs(plane.normal.dot(planes[0].normal)) > 1 - 1e-9;
  });
  const auto position = [&](size_t n) {
    return parallel ? planes[0].distance(planes[n].origin) : planes[n].index;
  };
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return position(a) < position(b); });
  return order;
}

double mostVoxelSize(const GridBase& prototype) {
  return isLevelSet(prototype) ? backgroundOf(prototype) / kHalfWidth
                               : std::numeric_limits<double>::infinity();
}

GridBase::Ptr gridOfSections(const std::vector<SectionPlane>& planes, const SlicedGrid& sliced,
                             double voxelSize) {
  const GridBase& prototype = *sliced.prototype;
  if (!(voxelSize <= mostVoxelSize(prototype) * 1.001))
    throw InputError("voxel size " + std::to_string(voxelSize) + ": the slices of '" + prototype.getName() +
                     "' hold distances up to " + std::to_string(backgroundOf(prototype)) +
                     ", three voxels of at most " + std::to_string(mostVoxelSize(prototype)));
  const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  GridBase::Ptr result;
  if (isLevelSet(prototype)) {
    const double band = backgroundOf(prototype);
    const Field field(planes, sliced, Vec3d(band), false, true, band);
    result = levelSetOf(field, *transform, voxelSize, band);
    result->insertMeta(prototype);
  } else {
    result = prototype.copyGridWithNewTree();
    result->apply<SliceableTypes>([&](auto& typed) {
      using Grid = std::decay_t<decltype(typed)>;
      using Value = typename Grid::ValueType;
      const bool whole = !std::is_floating_point_v<typename openvdb::VecTraits<Value>::ElementType>;
      Vec3d background;
      if constexpr (openvdb::VecTraits<Value>::IsVec)
        background = Vec3d(typed.background());
      else
        background = Vec3d(double(typed.background()));
      fillGrid(typed, Field(planes, sliced, background, whole, false, 0), voxelSize);
    });
    result->pruneGrid(0);
  }
  result->setTransform(transform);
  return result;
}

}  // namespace slicemorph

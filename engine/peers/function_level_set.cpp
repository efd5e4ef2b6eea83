#include "engine/peers/function_level_set.h"

#include "engine/peers/require.h"
#include "engine/rebuild/sweep_band.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace slicemorph {
namespace {

using FunctionLeaf = openvdb::FloatTree::LeafNodeType;

/// Leaves whose values are all further from 0 than so many bands are left out.
constexpr double kKeptBands = 4;

/// The voxels of a box and one more on either side, rounded to whole leaves.
openvdb::CoordBBox leavesOf(const FunctionBox& where) {
  const int side = int(FunctionLeaf::DIM), mask = ~(side - 1);
  const openvdb::Coord low = openvdb::Coord::floor(where.box.min() / where.voxelSize).offsetBy(-1);
  const openvdb::Coord high = openvdb::Coord::ceil(where.box.max() / where.voxelSize).offsetBy(1);
  return {low & mask, (high & mask).offsetBy(side - 1)};
}

void refuseTooMany(const FunctionBox& where) {
  constexpr double kMost = double(1 << 30);
  const Vec3d size = where.box.extents() / where.voxelSize;
  const double voxels = size[0] * size[1] * size[2];
  requireAtMost(
      "--method " + std::string(where.method) + " looks at every voxel of the box about its shape, ", voxels,
      kMost);
}

/// How far a point is outside of a box, along the axis where it is furthest; below 0 inside.
double outsideOf(const openvdb::BBoxd& box, const Vec3d& p) {
  double most = box.min()[0] - p[0];
  for (int axis = 0; axis < 3; ++axis)
    most = std::max({most, box.min()[axis] - p[axis], p[axis] - box.max()[axis]});
  return most;
}

/// Whether a leaf is near the surface.
bool isNear(const FunctionLeaf& leaf, float far) {
  const float* values = leaf.buffer().data();
  bool inside = false, outside = false;
  for (openvdb::Index n = 0; n < FunctionLeaf::SIZE; ++n) {
    if (std::abs(values[n]) < far) return true;
    (values[n] < 0 ? inside : outside) = true;
  }
  return inside && outside;
}

}  // namespace

FloatGrid::Ptr levelSetOfFunction(const FunctionBox& where, const std::function<PointFunction()>& function) {
  refuseTooMany(where);
  const float band = float(kHalfWidth * where.voxelSize);
  const openvdb::CoordBBox box = leavesOf(where);
  const auto side = openvdb::Index64(FunctionLeaf::DIM);
  const openvdb::Index64 nx = openvdb::Index64(box.dim()[0]) / side,
                         ny = openvdb::Index64(box.dim()[1]) / side,
                         nz = openvdb::Index64(box.dim()[2]) / side;
  std::vector<std::unique_ptr<FunctionLeaf>> leaves(nx * ny * nz);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, leaves.size(), 16), [&](const auto& range) {
    const PointFunction at = function();
    for (size_t i = range.begin(); i != range.end(); ++i) {
      const openvdb::Coord step(int(i / (ny * nz) * side), int(i / nz % ny * side), int(i % nz * side));
      auto leaf = std::make_unique<FunctionLeaf>(box.min() + step, 0.0f, true);
      for (openvdb::Index n = 0; n < FunctionLeaf::SIZE; ++n) {
        const Vec3d p = where.voxelSize * leaf->offsetToGlobalCoord(n).asVec3d();
        leaf->setValueOnly(n, std::max(at(p), float(outsideOf(where.box, p))));
      }
      if (isNear(*leaf, float(kKeptBands) * band)) leaves[i] = std::move(leaf);
    }
  });
  auto grid = FloatGrid::create(band);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(where.voxelSize));
  for (auto& leaf : leaves)
    if (leaf) grid->tree().addLeaf(leaf.release());
  openvdb::tools::signedFloodFill(grid->tree());
  return sweptLevelSet(*grid, band);
}

FloatGrid::Ptr emptyLevelSet(double voxelSize) {
  auto grid = FloatGrid::create(float(kHalfWidth * voxelSize));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxelSize));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setName("surface");
  return grid;
}

}  // namespace slicemorph

#include "engine/rebuild/flowing_density.h"

#include <openvdb/tools/Filter.h>

#include <algorithm>

namespace slicemorph {

namespace {

using Densities = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid>;

/// Means over 3 voxels along each axis, so many times: a bell of 2 voxels, as each adds 2/3 to the variance.
constexpr int kMeans = 6;

FloatGrid::Ptr asFloats(const openvdb::GridBase& grid) {
  if (grid.isType<FloatGrid>()) return static_cast<const FloatGrid&>(grid).deepCopy();
  if (grid.isType<openvdb::DoubleGrid>())
    return std::make_shared<FloatGrid>(static_cast<const openvdb::DoubleGrid&>(grid));
  return nullptr;
}

}  // namespace

void takeNearerDetail(openvdb::GridBase& blend, const openvdb::GridBase& difference, double t) {
  const double more = t * t / (t * t + (1 - t) * (1 - t)) - t;
  const FloatGrid::Ptr detail = asFloats(difference);
  if (more == 0 || !detail) return;
  const FloatGrid::Ptr smooth = detail->deepCopy();
  openvdb::tools::Filter<FloatGrid>(*smooth).mean(1, kMeans);
  blend.apply<Densities>([&](auto& grid) {
    using Value = typename std::decay_t<decltype(grid)>::ValueType;
    FloatGrid::ConstAccessor all = detail->getConstAccessor(), low = smooth->getConstAccessor();
    for (auto value = grid.beginValueOn(); value; ++value) {
      const openvdb::Coord at = value.getCoord();
      const double fine = double(all.getValue(at)) - double(low.getValue(at));
      value.setValue(Value(std::max(double(*value) + more * fine, 0.0)));
    }
  });
}

double totalOf(const openvdb::GridBase& grid) {
  double sum = 0;
  grid.apply<Densities>([&](const auto& typed) {
    for (auto value = typed.cbeginValueOn(); value; ++value)
      sum += double(*value) * double(value.getVoxelCount());
  });
  return sum * std::abs(grid.transform().baseMap()->determinant());
}

void scaleToTotal(openvdb::GridBase& grid, double total) {
  const double own = totalOf(grid);
  if (!(own > 0)) return;
  grid.apply<Densities>([&](auto& typed) {
    using Value = typename std::decay_t<decltype(typed)>::ValueType;
    for (auto value = typed.beginValueOn(); value; ++value)
      value.setValue(Value(double(*value) * (total / own)));
  });
}

}  // namespace slicemorph

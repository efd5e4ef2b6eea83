#include "engine/volume/level_set.h"

#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <openvdb/math/FiniteDifference.h>
#include <openvdb/tree/LeafManager.h>

#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace slicemorph {
namespace {

/// Relative tolerance for values stored as half floats: four times their rounding error of 2^-11.
constexpr float kHalfTolerance = 1.0f / 512;

struct ValueRange {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  size_t clamped = 0;  // active voxels at or beyond the background
  bool finite = true;

  void add(float value, float background) {
    finite = finite && std::isfinite(value);
    low = std::min(low, value);
    high = std::max(high, value);
    clamped += std::abs(value) >= background;
  }
  ValueRange joined(const ValueRange& other) const {
    return {std::min(low, other.low), std::max(high, other.high), clamped + other.clamped,
            finite && other.finite};
  }
};

/// Over the active values. The result does not depend on the order in which parts are joined.
ValueRange rangeOf(const FloatGrid& grid) {
  const float background = std::abs(grid.background());
  const openvdb::tree::LeafManager<const openvdb::FloatTree> leaves(grid.tree());
  ValueRange range = tbb::parallel_reduce(
      leaves.leafRange(64), ValueRange(),
      [&](const auto& part, ValueRange sum) {
        for (auto leaf = part.begin(); leaf; ++leaf) {
          for (auto value = leaf->cbeginValueOn(); value; ++value) sum.add(*value, background);
        }
        return sum;
      },
      [](const ValueRange& a, const ValueRange& b) { return a.joined(b); });
  auto tile = grid.tree().cbeginValueOn();
  for (tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1); tile; ++tile)
    range.add(*tile, background);
  return range;
}

/// Mean gradient length next to the surface, in value per voxel, over about a thousand leaves; 0 if there is
/// no surface.
double meanSlope(const FloatGrid& grid, double voxelSize) {
  const openvdb::tree::LeafManager<const openvdb::FloatTree> leaves(grid.tree());
  const size_t stride = leaves.leafCount() / 1024 + 1;
  using Sum = std::pair<double, size_t>;
  const Sum all = tbb::parallel_deterministic_reduce(
      leaves.leafRange(32), Sum(0, 0),
      [&](const auto& range, Sum sum) {
        const auto accessor = grid.getConstAccessor();
        for (auto leaf = range.begin(); leaf; ++leaf) {
          if (leaf.pos() % stride != 0) continue;
          for (auto value = leaf->cbeginValueOn(); value; ++value) {
            if (std::abs(*value) > 0.75 * voxelSize) continue;
            const openvdb::Coord c = value.getCoord();
            // Upwind differences: the ridge in the middle of a thin wall is no defect of its distances.
            Vec3d behind, ahead;
            for (int d = 0; d < 3; ++d) {
              openvdb::Coord step(0, 0, 0);
              step[d] = 1;
              behind[d] = *value - accessor.getValue(c - step);
              ahead[d] = accessor.getValue(c + step) - *value;
            }
            sum.first += std::sqrt(openvdb::math::GodunovsNormSqrd(*value > 0, behind, ahead));
            ++sum.second;
          }
        }
        return sum;
      },
      [](const Sum& x, const Sum& y) { return Sum(x.first + y.first, x.second + y.second); });
  return all.second ? all.first / double(all.second) : 0;
}

bool isUniformAndParallel(const openvdb::math::Transform& transform) {
  if (!transform.isLinear()) return false;
  const auto matrix = transform.baseMap()->getAffineMap()->getMat4();
  const double size = matrix(0, 0);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (std::abs(matrix(i, j) - (i == j ? size : 0)) > 1e-6 * std::abs(size)) return false;
    }
  }
  return size > 0;
}

/// Why a grid is not a level set as by the conventions, as part of a sentence; empty: it is one.
std::string deviation(const FloatGrid& grid, const ValueRange& range, double voxelSize) {
  const float background = grid.background();
  if (grid.getGridClass() != openvdb::GRID_LEVEL_SET) return "it is not of class level set";
  if (grid.tree().activeTileCount() > 0 || range.clamped * 20 > grid.activeVoxelCount()) return "it is dense";
  if (!isUniformAndParallel(grid.transform())) return "its voxels are not cubes parallel to the axes";
  if (std::abs(background - kHalfWidth * voxelSize) > kHalfTolerance * kHalfWidth * voxelSize) {
    std::ostringstream text;
    text << "its band is " << background / voxelSize << " voxels wide, not " << kHalfWidth;
    return text.str();
  }
  const float limit = background * (1 + kHalfTolerance);
  if (range.low < -limit || range.high > limit) return "its values go beyond its band";
  const double slope = meanSlope(grid, voxelSize) / voxelSize;
  if (slope < 0.8 || slope > 1.2) {
    std::ostringstream text;
    text << "its values are no distances (mean slope " << slope << ")";
    return text.str();
  }
  return "";
}

bool isFog(const FloatGrid& grid, const ValueRange& range) {
  if (grid.getGridClass() == openvdb::GRID_FOG_VOLUME) return true;
  return grid.getGridClass() == openvdb::GRID_UNKNOWN && grid.background() == 0 && range.low >= 0;
}

/// Calls add(value, number of voxels) for all active values.
template <typename Add>
void forActiveValues(const FloatGrid& grid, const Add& add) {
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    for (auto value = leaf->cbeginValueOn(); value; ++value) add(*value, size_t(1));
  auto tile = grid.tree().cbeginValueOn();
  for (tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1); tile; ++tile)
    add(*tile, size_t(tile.getVoxelCount()));
}

/// The value above which three quarters of a fog's total lie: it bounds the visible body, however dense
/// its densest spot. At most half the largest value, so that fog of uniform density has its surface
/// within its ramp.
double fogSurfaceValue(const FloatGrid& grid, double largest) {
  constexpr size_t kBins = 4096;  // the value is exact to 1/4096 of the largest one
  constexpr double kShare = 0.75;
  std::vector<size_t> count(kBins, 0);
  forActiveValues(grid, [&](float value, size_t voxels) {
    if (value > 0) count[std::min(size_t(value / largest * kBins), kBins - 1)] += voxels;
  });
  double total = 0, above = 0;
  for (size_t i = 0; i < kBins; ++i) total += double(count[i]) * (double(i) + 0.5);
  size_t bin = kBins - 1;
  while (bin > 0 && (above += double(count[bin]) * (double(bin) + 0.5)) < kShare * total) --bin;
  return std::min((double(bin) + 0.5) / kBins, 0.5) * largest;
}

double smallestVoxelSize(const FloatGrid& grid) {
  const Vec3d size = grid.voxelSize();
  return std::min({size.x(), size.y(), size.z()});
}

std::string noSurface(const LevelSetReading& reading) {
  std::ostringstream why;
  why << "the grid has no surface at " << reading.iso << ": its values run from " << reading.minimum << " to "
      << reading.maximum;
  return why.str();
}

std::string whyRebuilt(const FloatGrid& grid, const ValueRange& range, double voxelSize, double iso) {
  const double own = smallestVoxelSize(grid);
  const std::string why = deviation(grid, range, own);
  if (!why.empty()) return why;
  if (iso != 0) return "its surface is taken at another value than 0";
  return voxelSize > 0 && std::abs(voxelSize - own) > 1e-6 * own ? "another voxel size was asked for" : "";
}

}  // namespace

LevelSetReading readingOf(const FloatGrid& grid, double voxelSize, double iso) {
  LevelSetReading reading;
  reading.iso = iso;
  if (grid.empty()) {
    reading.problem = "the grid is empty: it has no active voxels";
    return reading;
  }
  const ValueRange range = rangeOf(grid);
  reading.minimum = range.low;
  reading.maximum = range.high;
  reading.fog = isFog(grid, range);
  if (reading.fog && iso == 0 && range.finite && range.high > 0)
    reading.iso = fogSurfaceValue(grid, range.high);
  // If all active values are on one side of the surface, the background may be on the other.
  const float low = std::min(range.low, grid.background()), high = std::max(range.high, grid.background());
  if (!range.finite) {
    reading.problem = "the grid holds values that are not finite";
  } else if (!(low < reading.iso && reading.iso <= high)) {
    reading.problem = noSurface(reading);
  } else {
    reading.rebuilt = whyRebuilt(grid, range, voxelSize, reading.iso);
  }
  return reading;
}

Mesh surfaceAsRead(const FloatGrid& grid, const LevelSetReading& reading) {
  if (!reading.fog || grid.getGridClass() == openvdb::GRID_FOG_VOLUME) return surfaceOf(grid, reading.iso);
  const FloatGrid::Ptr fog = FloatGrid::create(openvdb::ConstPtrCast<openvdb::FloatTree>(grid.treePtr()));
  fog->setTransform(grid.transform().copy());
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  return surfaceOf(*fog, reading.iso);
}

LevelSetInput toLevelSet(const FloatGrid::ConstPtr& grid, double voxelSize, double iso) {
  if (!std::isfinite(iso)) throw InputError("the iso value is not finite");
  if (!(voxelSize >= 0) || !std::isfinite(voxelSize)) {
    throw InputError("voxel size " + std::to_string(voxelSize) + " is no positive number of world units");
  }
  const LevelSetReading reading = readingOf(*grid, voxelSize, iso);
  if (!reading.problem.empty()) throw GeometryError(reading.problem);
  LevelSetInput result;
  result.fog = reading.fog;
  if (reading.rebuilt.empty()) {
    result.grid = openvdb::ConstPtrCast<FloatGrid>(grid);
    return result;
  }
  const Mesh mesh = surfaceAsRead(*grid, reading);
  if (mesh.triangles.empty()) throw GeometryError(noSurface(reading));
  result.grid = voxelise(mesh, voxelSize > 0 ? voxelSize : smallestVoxelSize(*grid));
  result.grid->setName(grid->getName());
  std::ostringstream note;
  note << "rebuilt as a level set from its surface at " << reading.iso
       << (reading.fog && iso == 0 ? " (found from the density; --iso sets another)" : "") << ": "
       << reading.rebuilt;
  result.notes.push_back({"volume.rebuilt", Severity::kNote, "", note.str()});
  return result;
}

}  // namespace slicemorph

#include "engine/reconstruct/contour_labels.h"

#include "engine/numerics/readable.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slicemorph {

namespace {

constexpr double kParallelPlanes = 1 - 1e-6;  // cosine: 0.08 degrees
constexpr double kOnPlane = 0.02;             // planes this close, in gaps, count as on the regular positions
constexpr double kMostVoxels = 2e9;           // 4 GB of 16-bit labels

struct Solid {
  const FloatGrid* grid;
  int label;
  openvdb::CoordBBox box;  // of the narrow band; everything beyond it is outside
  double volume = 0;
  Vec3d middle{0, 0, 0};
  size_t surface = 0;  // its number among those given
};

Solid solidOf(const FloatGrid& grid, int label) {
  Solid solid{&grid, label, grid.evalActiveVoxelBoundingBox()};
  Vec3d sum(0.0);
  double count = 0;
  for (auto it = grid.cbeginValueAll(); it; ++it) {
    if (*it >= 0) continue;
    openvdb::CoordBBox box;
    it.getBoundingBox(box);
    count += double(it.getVoxelCount());
    sum += double(it.getVoxelCount()) * 0.5 * (box.min().asVec3d() + box.max().asVec3d());
  }
  solid.volume = count * std::pow(grid.voxelSize()[0], 3);
  if (count > 0) solid.middle = grid.indexToWorld(sum / count);
  return solid;
}

/// The voxels of a lattice around an object, at least one.
ImageLattice croppedTo(const Solid& solid, const ImageLattice& on) {
  const openvdb::Mat3d toVoxels = openvdb::Mat3d(on.step[0], on.step[1], on.step[2], false).inverse();
  openvdb::BBoxd box;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d at;
    for (int a = 0; a < 3; ++a) at[a] = corner >> a & 1 ? solid.box.max()[a] : solid.box.min()[a];
    box.expand(toVoxels * (solid.grid->indexToWorld(at) - on.origin));
  }
  ImageLattice cropped = on;
  Vec3d first;
  for (int a = 0; a < 3; ++a) {
    const int low = std::clamp(int(std::floor(box.min()[a])), 0, on.size[a] - 1);
    const int high = std::clamp(int(std::ceil(box.max()[a])), low, on.size[a] - 1);
    first[a] = low, cropped.size[a] = high - low + 1;
  }
  cropped.origin = on.toWorld(first);
  return cropped;
}

bool before(const Solid& a, const Solid& b) {
  if (a.volume != b.volume) return a.volume < b.volume;
  return std::lexicographical_compare(a.middle.asPointer(), a.middle.asPointer() + 3, b.middle.asPointer(),
                                      b.middle.asPointer() + 3);
}

/// A map's values, and by solid the voxels inside it and those that the map shows of it.
template <typename Value>
struct Painting {
  std::vector<Value> values;
  std::vector<size_t> own, shown;
};

template <typename Value>
Painting<Value> paint(const std::vector<Solid>& solids, const ImageLattice& on, SharedVoxel rule) {
  std::vector<Value> values(on.count(), 0);
  const size_t count = solids.size();
  std::vector<size_t> own(size_t(on.size[2]) * count, 0), shown = own;
  tbb::parallel_for(0, on.size[2], [&](int k) {
    size_t *const mine = &own[size_t(k) * count], *const seen = &shown[size_t(k) * count];
    std::vector<FloatGrid::ConstAccessor> accessors;
    accessors.reserve(solids.size());
    for (const Solid& s : solids) accessors.push_back(s.grid->getConstAccessor());
    for (int j = 0; j < on.size[1]; ++j)
      for (int i = 0; i < on.size[0]; ++i) {
        const Vec3d world = on.toWorld(Vec3d(i, j, k));
        double depth = 0, band = 0;
        size_t winner = count;
        for (size_t s = 0; s < solids.size(); ++s) {
          const Vec3d at = solids[s].grid->worldToIndex(world);
          const openvdb::Coord node = openvdb::Coord::round(at);
          if (!solids[s].box.isInside(node)) continue;
          const double background = solids[s].grid->background();
          double value = accessors[s].getValue(node);
          // The band is wider than a voxel, so the sign cannot change next to a node outside of it.
          if (std::abs(value) < background) value = openvdb::tools::BoxSampler::sample(accessors[s], at);
          if (value >= 0) continue;
          ++mine[s];
          if (rule == SharedVoxel::smallest) {
            winner = std::min(winner, s);
            continue;
          }
          const double common = band > 0 ? std::min(band, background) : background;
          if (band > 0 && std::min(-value, common) <= std::min(depth, common)) continue;
          depth = -value, band = background, winner = s;
        }
        if (winner == count) continue;
        values[on.index(i, j, k)] = Value(solids[winner].label);
        ++seen[winner];
      }
  });
  for (size_t n = count; n < own.size(); ++n) own[n % count] += own[n], shown[n % count] += shown[n];
  own.resize(count), shown.resize(count);
  return {std::move(values), std::move(own), std::move(shown)};
}

template <typename Action>
void forPoints(const std::vector<ContourSet>& sets, const Action& action) {
  for (const ContourSet& set : sets)
    for (const PlaneContours& plane : set.planes)
      for (const auto& loop : plane.loops)
        for (const Vec2d& p : loop) action(plane.toWorld(p));
}

/// Heights of the planes with contours, ascending; empty if the planes are not parallel.
std::vector<double> heightsOf(const std::vector<ContourSet>& sets, const Vec3d& normal, double tolerance) {
  std::vector<double> heights, out;
  for (const ContourSet& set : sets)
    for (const PlaneContours& plane : set.planes) {
      if (plane.loops.empty()) continue;
      if (std::abs(plane.normal.dot(normal)) < kParallelPlanes) return {};
      heights.push_back(plane.origin.dot(normal));
    }
  std::sort(heights.begin(), heights.end());
  for (double h : heights)
    if (out.empty() || h > out.back() + tolerance) out.push_back(h);
  return out.size() < 2 ? std::vector<double>() : out;
}

/// The median gap, refined by all gaps that are whole multiples of it.
double usualGap(const std::vector<double>& heights) {
  std::vector<double> gaps;
  for (size_t i = 1; i < heights.size(); ++i) gaps.push_back(heights[i] - heights[i - 1]);
  std::nth_element(gaps.begin(), gaps.begin() + long(gaps.size() / 2), gaps.end());
  const double median = gaps[gaps.size() / 2];
  double sum = 0, count = 0;
  for (double g : gaps) {
    const double n = std::round(g / median);
    if (n >= 1 && std::abs(g - n * median) <= kOnPlane * median) sum += g, count += n;
  }
  return sum / count;
}

/// The plane from which most other planes are a whole number of steps away.
double anchorOf(const std::vector<double>& heights, double step) {
  double best = heights[0];
  int most = 0;
  for (double anchor : heights) {
    int count = 0;
    for (double h : heights)
      count += std::abs((h - anchor) / step - std::round((h - anchor) / step)) < kOnPlane;
    if (count > most) most = count, best = anchor;
  }
  return best;
}

}  // namespace

ContourMap contourMap(const std::vector<ContourSurface>& surfaces, const std::vector<int>& labels,
                      const ImageLattice& on, SharedVoxel rule) {
  if (surfaces.size() != labels.size())
    throw InputError(std::to_string(labels.size()) + " labels for " + std::to_string(surfaces.size()) +
                     " surfaces; one each");
  if (on.size[0] <= 0 || on.size[1] <= 0 || on.size[2] <= 0)
    throw InputError("the lattice of the labels has no voxels");
  std::vector<Solid> solids;
  int most = 0;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    if (labels[i] < 1 || labels[i] > 65535)
      throw InputError("label " + std::to_string(labels[i]) + " is not in 1..65535");
    most = std::max(most, labels[i]);
    solids.push_back(solidOf(*surfaces[i].grid, labels[i]));
    solids.back().surface = i;
  }
  std::stable_sort(solids.begin(), solids.end(), before);
  ContourMap map;
  map.image.lattice = on;
  map.own.resize(solids.size()), map.shown.resize(solids.size());
  const auto take = [&](auto painting) {
    map.image.values = std::move(painting.values);
    for (size_t s = 0; s < solids.size(); ++s)
      map.own[solids[s].surface] = painting.own[s], map.shown[solids[s].surface] = painting.shown[s];
  };
  if (most < 256)
    take(paint<std::uint8_t>(solids, on, rule));
  else
    take(paint<std::uint16_t>(solids, on, rule));
  return map;
}

Image contourLabels(const std::vector<ContourSurface>& surfaces, const std::vector<int>& labels,
                    const ImageLattice& on, SharedVoxel rule) {
  return contourMap(surfaces, labels, on, rule).image;
}

Image contourMask(const ContourSurface& surface, const ImageLattice& on, MaskOf extent) {
  const Solid solid = solidOf(*surface.grid, 1);
  Image mask;
  mask.lattice = extent == MaskOf::all ? on : croppedTo(solid, on);
  mask.values = paint<std::uint8_t>({solid}, mask.lattice, SharedVoxel::smallest).values;
  return mask;
}

ImageLattice contourLattice(const std::vector<ContourSet>& sets, double voxelSize) {
  if (!(voxelSize > 0) || !std::isfinite(voxelSize))
    throw InputError("voxel size " + std::to_string(voxelSize) + " is no positive number of world units");
  openvdb::BBoxd world;
  forPoints(sets, [&](const Vec3d& p) { world.expand(p); });
  if (world.empty()) throw GeometryError("no contours to lay a lattice around");
  PlaneContours axes;
  for (const ContourSet& set : sets)
    for (const PlaneContours& plane : set.planes)
      if (!plane.loops.empty()) axes = plane;
  const std::vector<double> heights = heightsOf(sets, axes.normal, 1e-4 * voxelSize);
  if (heights.empty()) axes = PlaneContours();
  const Vec3d directions[3] = {axes.x, axes.y, axes.normal};
  double spacing[3] = {voxelSize, voxelSize, voxelSize}, phase[3] = {0, 0, 0};
  double beyond = 0.75 * world.extents().length() / 32;
  if (!heights.empty()) {
    const double gap = usualGap(heights);
    spacing[2] = gap / std::ceil(gap / voxelSize - 1e-9);
    phase[2] = anchorOf(heights, spacing[2]);
    beyond = 0.75 * gap;
  }
  Vec3d low(1e300), high(-1e300);
  forPoints(sets, [&](const Vec3d& p) {
    for (int a = 0; a < 3; ++a)
      low[a] = std::min(low[a], p.dot(directions[a])), high[a] = std::max(high[a], p.dot(directions[a]));
  });
  ImageLattice lattice;
  lattice.origin = Vec3d(0.0);
  double count = 1;
  for (int a = 0; a < 3; ++a) {
    const double margin = a == 2 || heights.empty() ? beyond : 0;
    const double first = std::floor((low[a] - margin - phase[a]) / spacing[a]) - 2;
    const double last = std::ceil((high[a] + margin - phase[a]) / spacing[a]) + 2;
    count *= last - first + 1;
    if (count > kMostVoxels)
      throw InputError("voxel size " + std::to_string(voxelSize) + " would make a lattice of more than " +
                       readableCount(kMostVoxels) + " voxels; choose a larger one");
    lattice.size[a] = int(last - first) + 1;
    lattice.origin += (phase[a] + first * spacing[a]) * directions[a];
    lattice.step[a] = spacing[a] * directions[a];
  }
  return lattice;
}

}  // namespace slicemorph

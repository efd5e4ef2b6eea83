#include "engine/peers/outline_stack.h"

#include "engine/match/assignment.h"
#include "engine/numerics/readable.h"
#include "engine/peers/function_level_set.h"
#include "engine/reconstruct/plane_section.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

constexpr double kMostSlicePixels = double(1 << 28);

void refuseTooManyPixels(const SlicePlanes& planes, const std::string& method) {
  const double pixels = double(planes.nx) * planes.ny * double(planes.z0.size());
  if (!(pixels <= kMostSlicePixels))
    throw InputError("--method " + method + " cuts an object into slices of " + readableCount(pixels) +
                     " pixels; " + readableCount(kMostSlicePixels) +
                     " at most: choose fewer slices, a larger --voxel-size or a smaller --resolution");
}

/// Of one slice: the outlines that are holes, or those that are not.
std::vector<const Contour*> ofKind(const std::vector<Contour>& slice, bool hole) {
  std::vector<const Contour*> result;
  for (const Contour& contour : slice)
    if (contour.hole() == hole) result.push_back(&contour);
  return result;
}

/// The partners of some outlines among others, of which there are at least as many.
std::vector<int> partnersOf(const std::vector<const Contour*>& some, const Vec2d& middle,
                            const std::vector<const Contour*>& others, const Vec2d& otherMiddle) {
  if (some.empty()) return {};
  std::vector<std::vector<double>> cost(some.size(), std::vector<double>(others.size()));
  for (size_t i = 0; i < some.size(); ++i)
    for (size_t j = 0; j < others.size(); ++j)
      cost[i][j] = ((some[i]->centroid - middle) - (others[j]->centroid - otherMiddle)).length();
  return assign(cost);
}

void groupKind(const std::vector<OutlineStack>& objects, size_t slice, bool hole,
               std::vector<OutlineGroup>& groups) {
  std::vector<std::vector<const Contour*>> outlines;
  std::vector<Vec2d> middles;
  size_t most = 0;
  for (const OutlineStack& object : objects) {
    outlines.push_back(ofKind(object.slices[slice], hole));
    middles.push_back(momentsOf(object.slices[slice]).mean);
    if (outlines.back().size() > outlines[most].size()) most = outlines.size() - 1;
  }
  const size_t first = groups.size();
  for (const Contour* outline : outlines[most]) {
    OutlineGroup group;
    group.of.resize(objects.size());
    // A slice that is empty has its middle on the chart's axis.
    for (const Vec2d& middle : middles) group.centre.push_back(outline->centroid - middles[most] + middle);
    groups.push_back(std::move(group));
  }
  for (size_t k = 0; k < objects.size(); ++k) {
    const std::vector<int> partners = partnersOf(outlines[k], middles[k], outlines[most], middles[most]);
    for (size_t i = 0; i < partners.size(); ++i) {
      OutlineGroup& group = groups[first + size_t(partners[i])];
      group.of[k] = outlines[k][i], group.centre[k] = outlines[k][i]->centroid;
    }
  }
}

/// Signed distances on one slice; `empty` everywhere where it has no loops.
struct LoopImage {
  bool hasLoops = false;
  PlaneImage image;
};

LoopImage imageOf(const SliceLoops& loops, double voxelSize, const std::string& method) {
  constexpr double kSamePoint = 1e-6;  // voxels
  constexpr double kMarginVoxels = 8;
  PlaneContours plane;
  for (const auto& loop : loops)
    if (loop.size() >= 3) plane.loops.push_back(loop);
  LoopImage result;
  if (plane.loops.empty()) return result;
  Notes notes;
  const PlaneSection section = sectionOf(plane, kSamePoint * voxelSize, method, notes);
  result.hasLoops = !section.edges.empty();
  if (result.hasLoops) result.image = distanceImage(section, voxelSize, kMarginVoxels * voxelSize);
  return result;
}

/// The world box of a stack's slabs.
openvdb::BBoxd worldBox(const LoopStack& stack) {
  openvdb::BBoxd inChart;
  for (const SliceLoops& slice : stack.slices)
    for (const auto& loop : slice)
      for (const Vec2d& p : loop) {
        inChart.expand(Vec3d(stack.low, p[0], p[1]));
        inChart.expand(Vec3d(stack.high, p[0], p[1]));
      }
  openvdb::BBoxd world;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = corner >> a & 1 ? inChart.max()[a] : inChart.min()[a];
    world.expand(stack.chart.toWorld(p));
  }
  return world;
}

}  // namespace

OutlineStack cutOutlines(const DistanceField& field, const Chart& chart, const OutlineCut& cut) {
  openvdb::BBoxd box;
  for (const SurfaceSample& sample : field.samples()) box.expand(chart.toChart(sample.position));
  constexpr int kMargin = 3;  // pixels, so that no outline is cut by the border
  SlicePlanes planes;
  planes.pixel = cut.pixel;
  planes.origin = Vec2d(box.min()[1], box.min()[2]) - Vec2d(kMargin * cut.pixel);
  planes.nx = int(std::ceil(std::min(box.extents()[1] / cut.pixel, 1e6))) + 2 * kMargin + 1;
  planes.ny = int(std::ceil(std::min(box.extents()[2] / cut.pixel, 1e6))) + 2 * kMargin + 1;
  for (int i = 0; i < cut.slices; ++i)
    planes.z0.push_back(box.min()[0] + (i + 0.5) * box.extents()[0] / cut.slices);
  refuseTooManyPixels(planes, cut.method);

  OutlineStack stack{chart, box.min()[0], box.max()[0], {}};
  stack.slices.resize(planes.z0.size());
  const std::vector<SliceImage> images = sampleSlices(field, chart, planes);
  tbb::parallel_for(size_t(0), images.size(),
                    [&](size_t i) { stack.slices[i] = traceContours(images[i], planes); });
  return stack;
}

std::vector<OutlineGroup> groupOutlines(const std::vector<OutlineStack>& objects, size_t slice) {
  std::vector<OutlineGroup> groups;
  for (const bool hole : {false, true}) groupKind(objects, slice, hole, groups);
  return groups;
}

FloatGrid::Ptr surfaceOfLoops(const LoopStack& stack, double voxelSize) {
  const openvdb::BBoxd box = worldBox(stack);
  if (box.empty()) return emptyLevelSet(voxelSize);
  const int count = int(stack.slices.size());
  const double step = (stack.high - stack.low) / count;
  std::vector<LoopImage> images(stack.slices.size());
  tbb::parallel_for(size_t(0), images.size(),
                    [&](size_t i) { images[i] = imageOf(stack.slices[i], voxelSize, stack.method); });
  const auto onSlice = [&](int i, const Vec2d& p) {
    const LoopImage& slice = images[size_t(i)];
    return slice.hasLoops ? slice.image.at(p) : step;
  };
  const auto at = [&](const Vec3d& world) {
    const Vec3d z = stack.chart.toChart(world);
    const Vec2d p(z[1], z[2]);
    const double place = std::min(std::max((z[0] - stack.low) / step - 0.5, 0.0), double(count - 1));
    const int below = std::min(int(place), count - 1), above = std::min(below + 1, count - 1);
    const double share = place - below;
    const double within = (1 - share) * onSlice(below, p) + (share > 0 ? share * onSlice(above, p) : 0);
    return float(std::max({within, stack.low - z[0], z[0] - stack.high}));
  };
  return levelSetOfFunction({box, voxelSize, stack.method.c_str()}, [&]() -> PointFunction { return at; });
}

}  // namespace slicemorph

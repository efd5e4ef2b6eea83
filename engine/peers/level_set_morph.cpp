#include "engine/measure/matching_grid.h"
#include "engine/measure/measure.h"
#include "engine/peers/peers.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/LevelSetMorph.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

using openvdb::FloatTree;

/// Duration of one step. The front's speed is the difference of the two distances, at most two half widths (6
/// voxels), so it moves at most two voxels per step.
constexpr float kTimeStep = 1.0f / 3;
/// The front is at rest after this many steps without progress, neither in its largest distance to the target
/// nor in its mean.
constexpr int kPatience = 20;

/// Distance of one surface from another, in voxels, measured at the voxels next to the first. Beyond the band
/// it is clamped, which is good enough to tell whether the front has arrived or moves.
struct Gap {
  double max = 0, sum = 0;
  size_t voxels = 0;
};

Gap gapFrom(const FloatGrid& from, const FloatGrid& to) {
  using Leaves = openvdb::tree::LeafManager<const FloatTree>;
  const Leaves leaves(from.tree());
  const float h = float(from.voxelSize()[0]);
  std::vector<Gap> parts(leaves.leafCount());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, parts.size(), 64), [&](const auto& range) {
    auto accessor = to.getConstAccessor();
    for (size_t i = range.begin(); i != range.end(); ++i)
      for (auto value = leaves.leaf(i).cbeginValueOn(); value; ++value) {
        if (std::abs(*value) > 0.5f * h) continue;
        const double gap = std::abs(accessor.getValue(value.getCoord()) - *value) / h;
        parts[i].max = std::max(parts[i].max, gap), parts[i].sum += gap, ++parts[i].voxels;
      }
  });
  Gap total;
  for (const Gap& part : parts)
    total.max = std::max(total.max, part.max), total.sum += part.sum, total.voxels += part.voxels;
  return total;
}

Gap gapBetween(const FloatGrid& a, const FloatGrid& b) {
  const Gap there = gapFrom(a, b), back = gapFrom(b, a);
  return {std::max(there.max, back.max), there.sum + back.sum, there.voxels + back.voxels};
}

/// Keeps grids of a run of unknown length: every `stride`-th step; when there are too many, every other one
/// is dropped.
class Film {
 public:
  explicit Film(int count) : count_(count) {}
  void record(int step, const FloatGrid& grid) {
    if (step % stride_ != 0) return;
    grids_.push_back(grid.deepCopy());
    if (grids_.size() < 2 * size_t(count_)) return;
    for (size_t i = 1; 2 * i < grids_.size(); ++i) grids_[i] = grids_[2 * i];
    grids_.resize((grids_.size() + 1) / 2);
    stride_ *= 2;
  }
  /// `count` frames spread over the steps 0 to `steps`; the last one is `rest`.
  std::vector<FloatGrid::Ptr> cut(int steps, const FloatGrid::Ptr& rest) const {
    std::vector<FloatGrid::Ptr> frames;
    for (int i = 0; i + 1 < count_; ++i) {
      const double step = double(steps) * i / (count_ - 1);
      const size_t nearest = std::min(size_t(std::lround(step / stride_)), grids_.size() - 1);
      frames.push_back(grids_[nearest]);
    }
    frames.push_back(rest);
    return frames;
  }

 private:
  int count_, stride_ = 1;
  std::vector<FloatGrid::Ptr> grids_;
};

double surfaceDistanceInVoxels(const FloatGrid& a, const FloatGrid& b) {
  const Mesh meshA = surfaceOf(a), meshB = surfaceOf(b);
  if (meshA.triangles.empty() || meshB.triangles.empty()) return std::numeric_limits<double>::infinity();
  return surfaceDistance(meshA, meshB).max / a.voxelSize()[0];
}

/// Decides when a run is finished.
class Arrival {
 public:
  bool isOver(const Gap& gap, int step) {
    if (gap.max <= 0.5) return true;
    const double mean = gap.sum / std::max<size_t>(gap.voxels, 1);
    // Half a per cent per step counts as progress.
    if (gap.max < 0.995 * bestMax_ || mean < 0.995 * bestMean_) lastGain_ = step;
    bestMax_ = std::min(bestMax_, gap.max), bestMean_ = std::min(bestMean_, mean);
    return step - lastGain_ >= kPatience;
  }

 private:
  double bestMax_ = std::numeric_limits<double>::max(), bestMean_ = bestMax_;
  int lastGain_ = 0;
};

}  // namespace

LevelSetMorphResult levelSetMorph(const FloatGrid& source, const FloatGrid& target, int count, int maxSteps,
                                  Progress* progress) {
  if (count < 2) throw InputError("a level set morph needs at least 2 frames, not " + std::to_string(count));
  const FloatGrid::Ptr goal =
      source.transform() == target.transform() ? target.deepCopy() : sampleOnto(target, source.transform());
  const FloatGrid::Ptr front = source.deepCopy();
  front->setName("surface");
  front->setGridClass(openvdb::GRID_LEVEL_SET);

  openvdb::tools::LevelSetMorphing<FloatGrid> morph(*front, *goal);
  Film film(count);
  film.record(0, *front);
  Arrival arrival;
  LevelSetMorphResult result;
  while (result.steps < maxSteps && !arrival.isOver(gapBetween(*front, *goal), result.steps)) {
    if (progress) {
      if (progress->cancelled()) throw Cancelled();
      progress->report("moving the level set", double(result.steps) / maxSteps);
    }
    morph.advect(result.steps * kTimeStep, (result.steps + 1) * kTimeStep);
    film.record(++result.steps, *front);
    if (front->tree().leafCount() == 0) break;
  }
  result.frames = film.cut(result.steps, front);
  result.restDistance = surfaceDistanceInVoxels(*front, *goal);
  return result;
}

}  // namespace slicemorph

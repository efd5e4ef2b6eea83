#include "engine/reconstruct/join_pieces.h"

#include "engine/reconstruct/gap_scores.h"

#include <algorithm>
#include <functional>

namespace slicemorph {

namespace {

/// A slice of labels, or a plane's regions of one label.
class Neighbours {
 public:
  Neighbours(const PixelBox& domain, const int* slice) : domain_(domain), slice_(slice) {}
  explicit Neighbours(const LabelRegions* regions) : regions_(regions) {}

  /// Whether a pixel or one of the eight around it has the label.
  bool touch(int x, int y, int label) const {
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u)
        if (has(u, v, label)) return true;
    return false;
  }
  int count(int x, int y, int label) const {
    int sum = 0;
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u) sum += has(u, v, label);
    return sum;
  }

 private:
  bool has(int x, int y, int label) const {
    if (!slice_) return regions_ && regions_->at(x, y) >= 0;
    return domain_.contains(x, y) && slice_[domain_.index(x, y)] == label;
  }
  PixelBox domain_;
  const int* slice_ = nullptr;
  const LabelRegions* regions_ = nullptr;
};

/// Pixels of the label that a pixel is taken from, with it, in the 3 x 3 around it: so many that this is not cut by it.
constexpr int kFromBroad = 6;

/// In pixels: scores differ by twice the distance to the border between two labels, which is known to half a pixel.
constexpr float kNearly = 1;

/// One of the gap's planes and the slice next to it.
struct Side {
  const ScorePlane& plane;
  const std::vector<LabelRegions>& regions;  ///< per label of the plane
  Moment moment;                             ///< of the slice
  int* slice;
};

/// `beyond`: the slice or plane on the slice's other side.
void joinRegion(const SlicePlan& plan, const Side& side, const GapLabel& l,
                const std::vector<RegionRun>& runs, const Neighbours& beyond) {
  const PixelBox& domain = plan.stack.domain;
  const Neighbours here(domain, side.slice);
  for (const RegionRun& run : runs)
    for (int x = run.x0; x < run.x1; ++x)
      if (here.touch(x, run.y, l.label)) return;
  float least = kNearly * std::min(plan.stack.pixel[0], plan.stack.pixel[1]);
  size_t at = domain.count();
  for (const RegionRun& run : runs)
    for (int y = std::max(run.y - 1, domain.y0); y < std::min(run.y + 2, domain.y1); ++y)
      for (int x = std::max(run.x0 - 1, domain.x0); x < std::min(run.x1 + 1, domain.x1); ++x) {
        if (!here.touch(x, y, l.label) && !beyond.touch(x, y, l.label)) continue;
        const size_t pixel = domain.index(x, y);
        if (side.slice[pixel] < l.label || here.count(x, y, side.slice[pixel]) < kFromBroad) continue;
        const GapLabel& owner = labelIn(plan.gaps[side.moment.gap], side.slice[pixel]);
        const float margin = wholeScore(plan, owner, side.moment, float(x), float(y)) -
                             wholeScore(plan, l, side.moment, float(x), float(y));
        if (margin < least) least = margin, at = pixel;
      }
  if (at < domain.count()) side.slice[at] = l.label;
}

void joinSide(const SlicePlan& plan, const Gap& gap, const Side& side,
              const std::function<Neighbours(int)>& beyond) {
  for (size_t k = 0; k < side.plane.labels.size(); ++k) {
    const LabelRegions& regions = side.regions[k];
    const GapLabel& l = labelIn(gap, side.plane.labels[k].label);
    std::vector<std::vector<RegionRun>> runs(regions.regions.size());
    for (const RegionRun& run : regions.runs) runs[size_t(run.region)].push_back(run);
    for (const std::vector<RegionRun>& own : runs) joinRegion(plan, side, l, own, beyond(l.label));
  }
}

}  // namespace

void joinPieces(const SlicePlan& plan, size_t g, const std::vector<double>& positions,
                std::vector<int>& labels) {
  if (positions.empty()) return;
  const PixelBox& domain = plan.stack.domain;
  const size_t last = positions.size() - 1;
  const auto slice = [&](size_t i) { return &labels[i * domain.count()]; };
  const auto onPlane = [&](size_t k, int label) {
    const std::vector<LabelScore>& all = plan.stack.planes[k].labels;
    for (size_t i = 0; i < all.size(); ++i)
      if (all[i].label == label) return Neighbours(&plan.regions[k][i]);
    return Neighbours(nullptr);
  };
  const auto beyond = [&](size_t k, size_t next) {
    return [&, k, next](int label) { return last > 0 ? Neighbours(domain, slice(next)) : onPlane(k, label); };
  };
  joinSide(plan, plan.gaps[g],
           {plan.stack.planes[g], plan.regions[g], momentAt(plan.stack, positions[0]), slice(0)},
           beyond(g + 1, 1));
  joinSide(
      plan, plan.gaps[g],
      {plan.stack.planes[g + 1], plan.regions[g + 1], momentAt(plan.stack, positions[last]), slice(last)},
      beyond(g, last - 1));
}

}  // namespace slicemorph

#include "engine/reconstruct/fill_gaps.h"

#include "engine/numerics/parallel_each.h"
#include "engine/reconstruct/own_slices.h"
#include "slicemorph/errors.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <string>
#include <utility>

namespace slicemorph {

namespace {

/// Gaps that are filled at once: their planes' distances, with three planes of the neighbours, are in memory. (On 400
/// slices of 512 x 512 with 40 labels eight at once take no less time than five, and 4 MB more.)
constexpr size_t kLeastAtOnce = 5, kAtOncePerThread = 2;
/// Of wide gaps fewer: so many slices together, but one gap.
constexpr int kSlicesAtOnce = 64;

/// Fills in between slices that are given for all labels.
Image filledIn(Image labels, const GivenSlices& given) {
  const SliceLayout layout = layoutOf(labels.lattice, given.axis);
  const auto slice = [&](size_t k) { return LabelSlice{labels.values, layout, given.at[k]}; };
  const std::vector<double> ranked = rankLabels(labels, given);
  GapFiller filler(labels.lattice, given, ranked);
  while (!filler.done())
    filler.fill(slice, [&](const FilledGap& gap) {
      paintGap(gap, ranked, layout, given.at[gap.gap] + 1, labels.values);
    });
  return labels;
}

}  // namespace

void checkGivenSlices(const ImageLattice& lattice, const GivenSlices& given) {
  if (given.axis < 0 || given.axis > 2)
    throw InputError("axis must be 0, 1 or 2, got " + std::to_string(given.axis));
  if (given.at.size() < 2)
    throw InputError("at least two given slices are needed, got " + std::to_string(given.at.size()));
  for (size_t i = 0; i < given.at.size(); ++i)
    if (given.at[i] < 0 || given.at[i] >= lattice.size[given.axis] || (i && given.at[i] <= given.at[i - 1]))
      throw InputError("given slices must ascend within 0 to " +
                       std::to_string(lattice.size[given.axis] - 1) + ", got " + std::to_string(given.at[i]));
}

GapFiller::GapFiller(const ImageLattice& lattice, GivenSlices given, std::vector<double> ranked)
    : given_(std::move(given)), ranked_(std::move(ranked)) {
  checkGivenSlices(lattice, given_);
  spacing_ = lattice.spacing()[given_.axis];
  stack_ = emptyStack(lattice, given_.axis);
}

GapRange GapFiller::next() const {
  const size_t atOnce =
      std::max(kLeastAtOnce, kAtOncePerThread * size_t(tbb::this_task_arena::max_concurrency()));
  const size_t most = std::min(filled_ + atOnce, given_.at.size() - 1);
  size_t end = filled_ + 1;
  while (end < most && given_.at[end + 1] - given_.at[filled_] <= kSlicesAtOnce) ++end;
  return {filled_, end};
}

/// A label's path through a gap bends with the planes beyond it.
size_t GapFiller::slicesNeeded() const { return std::min(next().end + 2, given_.at.size()); }

void GapFiller::fill(const std::function<LabelSlice(size_t)>& slice,
                     const std::function<void(FilledGap)>& put) {
  const GapRange gaps = next();
  const size_t firstPlane = gaps.first > 0 ? gaps.first - 1 : 0, endPlane = slicesNeeded();
  std::vector<ScorePlane>& planes = stack_.planes;
  planes.erase(planes.begin(), planes.begin() + std::ptrdiff_t(firstPlane - firstPlane_));
  const size_t kept = planes.size();
  planes.resize(endPlane - firstPlane);
  parallelEach(planes.size() - kept, [&](size_t n) {
    const size_t k = firstPlane + kept + n;
    planes[kept + n] = scoredPlane(slice(k), ranked_, stack_, given_.at[k] * spacing_);
  });
  SliceScores scores(std::move(stack_), {gaps.first - firstPlane, gaps.end - firstPlane});
  parallelEach(gaps.end - gaps.first, [&](size_t n) {
    const size_t g = gaps.first + n;
    const int first = given_.at[g] + 1, count = given_.at[g + 1] - first;
    std::vector<double> positions;
    positions.reserve(size_t(count));
    for (int k = 0; k < count; ++k) positions.push_back((first + k) * spacing_);
    put({g, count, count > 0 ? scores.labelsBetween(positions) : std::vector<int>()});
  });
  stack_ = std::move(scores).takeStack();
  firstPlane_ = firstPlane, filled_ = gaps.end;
}

void paintGap(const FilledGap& gap, const std::vector<double>& ranked, const SliceLayout& layout, int first,
              ImageValues& to) {
  std::visit(
      [&](auto& out) {
        using T = typename std::decay_t<decltype(out)>::value_type;
        std::vector<T> paint;
        paint.reserve(ranked.size());
        for (double v : ranked) paint.push_back(T(v));
        T* corner = out.data() + size_t(first) * layout.slice;
        const size_t w = size_t(layout.width), h = size_t(layout.height), count = size_t(gap.slices);
        const auto put = [to = corner, won = gap.ranks.data(), paint = paint.data(), w, h, layout](
                             size_t k, size_t x, size_t y) {
          to[k * layout.slice + y * layout.y + x * layout.x] = paint[won[(k * h + y) * w + x]];
        };
        // The image's fastest axis is the innermost loop.
        if (layout.slice == 1) {
          for (size_t y = 0; y < h; ++y)
            for (size_t x = 0; x < w; ++x)
              for (size_t k = 0; k < count; ++k) put(k, x, y);
        } else {
          for (size_t k = 0; k < count; ++k)
            for (size_t y = 0; y < h; ++y)
              for (size_t x = 0; x < w; ++x) put(k, x, y);
        }
      },
      to);
}

Image interpolateLabels(Image labels, const GivenSlices& given) {
  checkGivenSlices(labels.lattice, given);
  if (given.own.empty()) return filledIn(std::move(labels), given);
  const std::vector<LabelGroup> groups = groupsOf(given);
  Image dense = filledIn(onlyGroup(labels, groups, 0), given);
  for (size_t g = 1; g < groups.size(); ++g) {
    Image own = onlyGroup(labels, groups, g);
    if (groups[g].given.at.size() > 1) own = filledIn(std::move(own), groups[g].given);
    mergeGroup(labels, groups, g, own, dense);
  }
  return dense;
}

}  // namespace slicemorph

#include "engine/reconstruct/label_slices.h"

#include "engine/numerics/mask_distance.h"
#include "engine/numerics/parallel_each.h"
#include "engine/reconstruct/slice_runs.h"

#include <cmath>
#include <numeric>
#include <unordered_map>

namespace slicemorph {

namespace {

/// The labels of one given slice in the order of appearance, and each pixel's index among them.
struct Census {
  std::vector<int> values, pixel;
  std::vector<PixelBox> box;
};

Census censusOf(const LabelSlice& slice) {
  Census census;
  std::unordered_map<int, int> seen;
  census.pixel.resize(size_t(slice.layout.width) * size_t(slice.layout.height));
  size_t at = 0;
  const auto add = [&](int x, int y, int end, int value) {
    const auto found = seen.emplace(value, int(census.values.size()));
    if (found.second) census.values.push_back(value), census.box.emplace_back();
    const size_t entry = size_t(found.first->second), count = size_t(end - x);
    std::fill_n(census.pixel.begin() + std::ptrdiff_t(at), count, int(entry));
    at += count;
    census.box[entry] = hull(census.box[entry], {x, y, end, y + 1});
  };
  visitRuns(slice, add);
  return census;
}

/// Share of the smoothing applied to the distances, because pixels turn a smooth contour into stairs. Chosen
/// by hand; guarded by label_slices_test.cpp.
constexpr float kSoft = 0.35f;
constexpr float kLeast = 1e-3f;  ///< in pixels: smoothing moves no pixel across the contour

/// Smooths with weights 1/4, 1/2, 1/4 along x and y, mixed in by shares `sx` and `sy`; keeps signs.
void soften(std::vector<float>& v, const PixelBox& box, float sx, float sy, float least) {
  const size_t w = size_t(box.width()), n = size_t(box.height());
  std::vector<float> along(v.size());
  for (size_t y = 0; y < n; ++y)
    for (size_t x = 0, i = y * w; x < w; ++x, ++i)
      along[i] = v[i] + 0.25f * sx * (v[x > 0 ? i - 1 : i] + v[x + 1 < w ? i + 1 : i] - 2 * v[i]);
  for (size_t y = 0; y < n; ++y)
    for (size_t x = 0, i = y * w; x < w; ++x, ++i) {
      const float two = along[y > 0 ? i - w : i] + along[y + 1 < n ? i + w : i];
      const float soft = along[i] + 0.25f * sy * (two - 2 * along[i]);
      v[i] = v[i] > 0 ? std::max(soft, least) : std::min(soft, -least);
    }
}

}  // namespace

SliceLayout layoutOf(const ImageLattice& lattice, int axis) {
  const int u = axis == 0 ? 1 : 0, w = axis == 2 ? 1 : 2;
  const size_t stride[3] = {1, size_t(lattice.size[0]), size_t(lattice.size[0]) * size_t(lattice.size[1])};
  return {lattice.size[u], lattice.size[w], stride[u], stride[w], stride[axis]};
}

LabelCount countLabels(const LabelSlice& slice) {
  LabelCount result;
  std::unordered_map<int, size_t> seen;
  const auto add = [&](int x, int, int end, int value) {
    const auto found = seen.emplace(value, result.values.size());
    if (found.second) result.values.push_back(value), result.count.push_back(0);
    result.count[found.first->second] += size_t(end - x);
  };
  visitRuns(slice, add);
  return result;
}

std::vector<double> rankLabels(const std::vector<LabelCount>& slices) {
  LabelCount all;
  std::unordered_map<int, size_t> indexOf;
  for (const LabelCount& slice : slices)
    for (size_t i = 0; i < slice.values.size(); ++i) {
      const auto found = indexOf.emplace(slice.values[i], all.values.size());
      if (found.second) all.values.push_back(slice.values[i]), all.count.push_back(0);
      all.count[found.first->second] += slice.count[i];
    }
  std::vector<size_t> order(all.values.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return all.count[a] < all.count[b]; });
  std::vector<double> ranked;
  ranked.reserve(order.size());
  for (size_t i : order) ranked.push_back(all.values[i]);
  return ranked;
}

ScoreStack emptyStack(const ImageLattice& lattice, int axis) {
  const SliceLayout layout = layoutOf(lattice, axis);
  const Vec3d spacing = lattice.spacing();
  ScoreStack stack;
  stack.pixel[0] = float(spacing[axis == 0 ? 1 : 0]), stack.pixel[1] = float(spacing[axis == 2 ? 1 : 2]);
  stack.domain = {0, 0, layout.width, layout.height};
  return stack;
}

ScorePlane scoredPlane(const LabelSlice& slice, const std::vector<double>& ranked, const ScoreStack& stack,
                       double position) {
  const Census census = censusOf(slice);
  std::unordered_map<int, int> rank;
  for (size_t i = 0; i < ranked.size(); ++i) rank[int(ranked[i])] = int(i);
  // A label that fills its slice has no border there; its border is assumed to be one diagonal of
  // the slice away.
  const float far =
      std::hypot(float(stack.domain.width()) * stack.pixel[0], float(stack.domain.height()) * stack.pixel[1]);
  ScorePlane plane;
  plane.position = position;
  const float least = std::min(stack.pixel[0], stack.pixel[1]), sx = least / stack.pixel[0],
              sy = least / stack.pixel[1];
  for (size_t e = 0; e < census.values.size(); ++e) {
    const PixelBox box = intersection(census.box[e].grown(1), stack.domain);
    std::vector<std::uint8_t> mask(box.count());
    for (int y = box.y0; y < box.y1; ++y) {
      const int* pixel = &census.pixel[stack.domain.index(box.x0, y)];
      std::uint8_t* to = &mask[box.index(box.x0, y)];
      for (int x = 0; x < box.width(); ++x) to[x] = pixel[x] == int(e);
    }
    std::vector<float> values = maskDistance(mask, box, stack.pixel[0], stack.pixel[1], far);
    soften(values, box, kSoft * sx * sx, kSoft * sy * sy, kLeast * least);
    plane.labels.push_back({rank.at(census.values[e]), box, std::move(values)});
  }
  std::sort(plane.labels.begin(), plane.labels.end(),
            [](const LabelScore& a, const LabelScore& b) { return a.label < b.label; });
  return plane;
}

std::vector<double> rankLabels(const Image& labels, const GivenSlices& given) {
  const SliceLayout layout = layoutOf(labels.lattice, given.axis);
  std::vector<LabelCount> counts(given.at.size());
  parallelEach(counts.size(), [&](size_t k) {
    counts[k] = countLabels({labels.values, layout, given.at[k]});
  });
  return rankLabels(counts);
}

RankedSlices rankSlices(const Image& labels, const GivenSlices& given) {
  const SliceLayout layout = layoutOf(labels.lattice, given.axis);
  const double spacing = labels.lattice.spacing()[given.axis];
  const size_t count = given.at.size();
  RankedSlices result{emptyStack(labels.lattice, given.axis), rankLabels(labels, given)};
  result.stack.planes.resize(count);
  parallelEach(count, [&](size_t k) {
    result.stack.planes[k] =
        scoredPlane({labels.values, layout, given.at[k]}, result.values, result.stack, given.at[k] * spacing);
  });
  return result;
}

}  // namespace slicemorph

#include "engine/reconstruct/label_slices.h"

#include "engine/numerics/mask_distance.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numeric>
#include <string>
#include <unordered_map>

namespace slicemorph {

namespace {

/// Memory layout of a slice's pixels (x fastest) in the image.
struct SliceLayout {
  int width, height;
  size_t x, y, slice;  ///< strides
};

SliceLayout layoutOf(const ImageLattice& lattice, int axis) {
  const int u = axis == 0 ? 1 : 0, w = axis == 2 ? 1 : 2;
  const size_t stride[3] = {1, size_t(lattice.size[0]), size_t(lattice.size[0]) * size_t(lattice.size[1])};
  return {lattice.size[u], lattice.size[w], stride[u], stride[w], stride[axis]};
}

/// The labels of one given slice in the order of appearance, and each pixel's index among them.
struct Census {
  std::vector<int> values, pixel;
  std::vector<size_t> count;
  std::vector<PixelBox> box;
};

template <typename T>
Census takeCensus(const std::vector<T>& values, const SliceLayout& layout, int slice) {
  Census census;
  std::unordered_map<int, int> seen;
  census.pixel.resize(size_t(layout.width) * size_t(layout.height));
  size_t at = 0;
  for (int y = 0; y < layout.height; ++y)
    for (int x = 0, end = 0; x < layout.width; x = end) {
      const T* row = &values[size_t(slice) * layout.slice + size_t(y) * layout.y];
      const T v = row[size_t(x) * layout.x];
      for (end = x + 1; end < layout.width && row[size_t(end) * layout.x] == v;) ++end;
      const auto found = seen.emplace(int(v), int(census.values.size()));
      if (found.second) census.values.push_back(int(v)), census.count.push_back(0), census.box.emplace_back();
      const size_t entry = size_t(found.first->second), count = size_t(end - x);
      std::fill_n(census.pixel.begin() + std::ptrdiff_t(at), count, int(entry));
      census.count[entry] += count, at += count;
      census.box[entry] = hull(census.box[entry], {x, y, end, y + 1});
    }
  return census;
}

/// Label values in ascending order of their number of pixels on all given slices; ties by first appearance.
std::vector<int> rankValues(const std::vector<Census>& slices) {
  std::vector<int> values;
  std::vector<size_t> count;
  std::unordered_map<int, size_t> indexOf;
  for (const Census& c : slices)
    for (size_t i = 0; i < c.values.size(); ++i) {
      const auto found = indexOf.emplace(c.values[i], values.size());
      if (found.second) values.push_back(c.values[i]), count.push_back(0);
      count[found.first->second] += c.count[i];
    }
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return count[a] < count[b]; });
  std::vector<int> ranked;
  ranked.reserve(order.size());
  for (size_t i : order) ranked.push_back(values[i]);
  return ranked;
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

ScorePlane scorePlane(const Census& census, const std::unordered_map<int, int>& rank, const ScoreStack& stack,
                      float far) {
  ScorePlane plane;
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

void checkGiven(const Image& labels, const GivenSlices& given) {
  if (given.axis < 0 || given.axis > 2)
    throw InputError("axis must be 0, 1 or 2, got " + std::to_string(given.axis));
  if (given.at.size() < 2)
    throw InputError("at least two given slices are needed, got " + std::to_string(given.at.size()));
  for (size_t i = 0; i < given.at.size(); ++i)
    if (given.at[i] < 0 || given.at[i] >= labels.lattice.size[given.axis] ||
        (i && given.at[i] <= given.at[i - 1]))
      throw InputError("given slices must ascend within 0 to " +
                       std::to_string(labels.lattice.size[given.axis] - 1) + ", got " +
                       std::to_string(given.at[i]));
}

}  // namespace

RankedSlices rankSlices(const Image& labels, const GivenSlices& given) {
  checkGiven(labels, given);
  const SliceLayout layout = layoutOf(labels.lattice, given.axis);
  const Vec3d spacing = labels.lattice.spacing();
  RankedSlices result;
  ScoreStack& stack = result.stack;
  stack.pixel[0] = float(spacing[given.axis == 0 ? 1 : 0]),
  stack.pixel[1] = float(spacing[given.axis == 2 ? 1 : 2]);
  stack.domain = {0, 0, layout.width, layout.height};
  std::vector<Census> census(given.at.size());
  std::visit(
      [&](const auto& values) {
        tbb::parallel_for(size_t(0), census.size(),
                          [&](size_t k) { census[k] = takeCensus(values, layout, given.at[k]); });
      },
      labels.values);
  const std::vector<int> ranked = rankValues(census);
  std::unordered_map<int, int> rank;
  for (size_t i = 0; i < ranked.size(); ++i) rank[ranked[i]] = int(i), result.values.push_back(ranked[i]);
  // A label that fills its slice has no border there; its border is assumed to be one diagonal of
  // the slice away.
  const float far = std::hypot(float(layout.width) * stack.pixel[0], float(layout.height) * stack.pixel[1]);
  stack.planes.resize(census.size());
  tbb::parallel_for(size_t(0), census.size(), [&](size_t k) {
    stack.planes[k] = scorePlane(census[k], rank, stack, far);
    stack.planes[k].position = given.at[k] * spacing[given.axis];
  });
  return result;
}

Image interpolateLabels(const Image& labels, const GivenSlices& given) {
  RankedSlices ranked = rankSlices(labels, given);
  const std::vector<double> values = std::move(ranked.values);
  const SliceScores scores(std::move(ranked.stack));
  const SliceLayout layout = layoutOf(labels.lattice, given.axis);
  const double spacing = labels.lattice.spacing()[given.axis];
  Image dense = labels;
  std::visit(
      [&](auto& out) {
        using T = typename std::decay_t<decltype(out)>::value_type;
        std::vector<T> paint;
        paint.reserve(values.size());
        for (double v : values) paint.push_back(T(v));
        tbb::parallel_for(size_t(0), given.at.size() - 1, [&](size_t g) {
          const int first = given.at[g] + 1, count = given.at[g + 1] - first;
          std::vector<double> positions;
          positions.reserve(size_t(count));
          for (int k = 0; k < count; ++k) positions.push_back((first + k) * spacing);
          const std::vector<int> won = scores.labelsBetween(positions);
          T* corner = out.data() + size_t(first) * layout.slice;
          const size_t w = size_t(layout.width), h = size_t(layout.height);
          const auto put = [to = corner, won = won.data(), paint = paint.data(), w, h, layout](
                               size_t k, size_t x, size_t y) {
            to[k * layout.slice + y * layout.y + x * layout.x] = paint[won[(k * h + y) * w + x]];
          };
          // The image's fastest axis is the innermost loop.
          if (layout.slice == 1) {
            for (size_t y = 0; y < h; ++y)
              for (size_t x = 0; x < w; ++x)
                for (size_t k = 0; k < size_t(count); ++k) put(k, x, y);
          } else {
            for (size_t k = 0; k < size_t(count); ++k)
              for (size_t y = 0; y < h; ++y)
                for (size_t x = 0; x < w; ++x) put(k, x, y);
          }
        });
      },
      dense.values);
  return dense;
}

}  // namespace slicemorph

#include "engine/reconstruct/mask_distance.h"

#include <cmath>

namespace slicemorph {

namespace {

constexpr int kNone = 1 << 20;  ///< rows to the nearest pixel of a column that has none

/// Lower envelope of parabolas along one row.
struct Envelope {
  std::vector<int> apex;
  std::vector<float> from, height;

  explicit Envelope(int width) : apex(size_t(width)), from(size_t(width) + 1), height(size_t(width)) {}
};

/// Distance of one row's pixels where `keep` says so to the nearest pixel; `rows`: rows to it within each
/// column.
void rowDistance(const int* rows, const std::uint8_t* mask, std::uint8_t keep, int width, float stepX,
                 float stepY, float sign, float far, Envelope& e, float* out) {
  int top = -1;
  const float inverse = 1 / (2 * stepX * stepX);
  for (int x = 0; x < width; ++x) {
    if (rows[x] >= kNone) continue;
    // Between two pixels of the other side it is nobody's nearest.
    if (x > 0 && x + 1 < width && rows[x - 1] + rows[x] + rows[x + 1] == 0) continue;
    const float h = float(rows[x]) * stepY, lifted = h * h + stepX * stepX * float(x) * float(x);
    float start = -1e30f;
    while (top >= 0) {
      const int a = e.apex[size_t(top)];
      start = (lifted - e.height[size_t(top)]) * inverse / float(x - a);
      if (start > e.from[size_t(top)]) break;
      --top, start = -1e30f;
    }
    ++top;
    e.apex[size_t(top)] = x, e.from[size_t(top)] = start, e.height[size_t(top)] = lifted;
  }
  const float half = 0.5f * std::min(stepX, stepY);
  int k = 0;
  for (int x = 0; x < width; ++x) {
    if (mask[x] != keep) continue;
    if (top < 0) {
      out[x] = sign * far;
      continue;
    }
    while (k < top && e.from[size_t(k) + 1] < float(x)) ++k;
    const int a = e.apex[size_t(k)];
    const float dx = float(x - a) * stepX, dy = float(rows[a]) * stepY;
    out[x] = sign * (std::sqrt(dx * dx + dy * dy) - half);
  }
}

/// Rows from every pixel to the nearest one of its column whose mask is `value`.
void columnRows(const std::vector<std::uint8_t>& mask, const PixelBox& box, std::uint8_t value,
                std::vector<int>& rows) {
  const size_t w = size_t(box.width()), h = size_t(box.height());
  for (size_t x = 0; x < w; ++x) rows[x] = mask[x] == value ? 0 : kNone;
  for (size_t y = 1; y < h; ++y)
    for (size_t x = 0; x < w; ++x) {
      const size_t i = y * w + x;
      rows[i] = mask[i] == value ? 0 : std::min(rows[i - w] + 1, kNone);
    }
  for (size_t y = h - 1; y-- > 0;)
    for (size_t x = 0; x < w; ++x) {
      const size_t i = y * w + x;
      rows[i] = std::min(rows[i], rows[i + w] + 1);
    }
}

}  // namespace

std::vector<float> maskDistance(const std::vector<std::uint8_t>& mask, const PixelBox& box, float stepX,
                                float stepY, float far) {
  std::vector<float> out(box.count());
  std::vector<int> rows(box.count());
  Envelope envelope(box.width());
  for (std::uint8_t side = 0; side < 2; ++side) {
    const std::uint8_t other = 1 - side;
    columnRows(mask, box, other, rows);
    for (int y = 0; y < box.height(); ++y) {
      const size_t row = size_t(y) * size_t(box.width());
      rowDistance(&rows[row], &mask[row], side, box.width(), stepX, stepY, side ? 1.0f : -1.0f, far, envelope,
                  &out[row]);
    }
  }
  return out;
}

}  // namespace slicemorph

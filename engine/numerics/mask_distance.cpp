#include "engine/numerics/mask_distance.h"

#include "engine/numerics/lower_envelope.h"

#include <cmath>

namespace slicemorph {

namespace {

constexpr int kNoRow = 1 << 20;  ///< larger than any number of rows: the column has no such pixel

/// Computes distances along rows of a mask.
class MaskRow {
 public:
  MaskRow(int width, float stepX, float stepY)
      : width_(width), stepX_(stepX), stepY_(stepY), envelope_(width, stepX * stepX) {}

  /// For the pixels whose mask is `side`: signed distances to the nearest pixel of the other side. `rows`:
  /// per column, rows to the nearest such pixel.
  void measure(const int* rows, const std::uint8_t* mask, std::uint8_t side, float far, float* out) {
    envelope_.clear();
    for (int x = 0; x < width_; ++x) {
      if (rows[x] >= kNoRow) continue;
      // Between two pixels of the other side it is nearest to no pixel of `side`.
      if (x > 0 && x + 1 < width_ && rows[x - 1] + rows[x] + rows[x + 1] == 0) continue;
      const float height = float(rows[x]) * stepY_;
      envelope_.add(x, height * height);
    }
    const float half = 0.5f * std::min(stepX_, stepY_), sign = side ? 1.0f : -1.0f;
    for (int x = 0; x < width_; ++x) {
      if (mask[x] != side) continue;
      if (envelope_.empty()) {
        out[x] = sign * far;
        continue;
      }
      const int a = envelope_.nearest(x);
      const float dx = float(x - a) * stepX_, dy = float(rows[a]) * stepY_;
      out[x] = sign * (std::sqrt(dx * dx + dy * dy) - half);
    }
  }

 private:
  int width_;
  float stepX_, stepY_;
  LowerEnvelope<float> envelope_;
};

/// Per pixel: rows to the nearest pixel of its column whose mask is `value`.
void columnRows(const std::vector<std::uint8_t>& mask, const PixelBox& box, std::uint8_t value,
                std::vector<int>& rows) {
  const size_t w = size_t(box.width()), h = size_t(box.height());
  for (size_t x = 0; x < w; ++x) rows[x] = mask[x] == value ? 0 : kNoRow;
  for (size_t y = 1; y < h; ++y)
    for (size_t x = 0; x < w; ++x) {
      const size_t i = y * w + x;
      rows[i] = mask[i] == value ? 0 : std::min(rows[i - w] + 1, kNoRow);
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
  MaskRow line(box.width(), stepX, stepY);
  for (std::uint8_t side = 0; side < 2; ++side) {
    columnRows(mask, box, std::uint8_t(1 - side), rows);
    for (int y = 0; y < box.height(); ++y) {
      const size_t row = size_t(y) * size_t(box.width());
      line.measure(&rows[row], &mask[row], side, far, &out[row]);
    }
  }
  return out;
}

}  // namespace slicemorph

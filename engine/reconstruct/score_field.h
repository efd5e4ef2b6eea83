#pragma once

#include "engine/reconstruct/slice_scores.h"

#include <cmath>

namespace slicemorph {

/// Reads a label's score at any point of its plane (pixels): bilinear in its box, beyond it the distance goes on.
struct ScoreField {
  const float* values = nullptr;
  PixelBox box;
  PixelBox domain;
  float pixel[2] = {1, 1};

  ScoreField() = default;
  ScoreField(const LabelScore& score, const ScoreStack& stack)
      : values(score.values.data()), box(score.box), domain(stack.domain), pixel{stack.pixel[0], stack.pixel[1]},
        corner{float(score.box.x0), float(score.box.y0)},
        last{float(score.box.width() - 1), float(score.box.height() - 1)}, row(size_t(score.box.width())) {}
  explicit operator bool() const { return values != nullptr; }

  float at(float x, float y) const {
    const float rx = x - corner[0], ry = y - corner[1];
    if (!(rx >= 0 && ry >= 0 && rx < last[0] && ry < last[1])) return atRim(x, y);
    const int ix = int(rx), iy = int(ry);
    const float fx = rx - float(ix), fy = ry - float(iy);
    const float* p = values + size_t(iy) * row + size_t(ix);
    const float* q = p + row;
    const float low = p[0] + fx * (p[1] - p[0]), high = q[0] + fx * (q[1] - q[0]);
    return low + fy * (high - low);
  }

 private:
  float corner[2] = {0, 0}, last[2] = {0, 0};  ///< the box in floats: its first pixel, and from it to the last
  size_t row = 0;

  float atRim(float x, float y) const {
    const float cx = std::min(std::max(x, float(box.x0)), float(box.x1 - 1));
    const float cy = std::min(std::max(y, float(box.y0)), float(box.y1 - 1));
    const int w = box.width();
    const int ix = std::max(std::min(int(cx) - box.x0, w - 2), 0),
        iy = std::max(std::min(int(cy) - box.y0, box.height() - 2), 0);
    const float fx = cx - float(ix + box.x0), fy = cy - float(iy + box.y0);
    const float* p = values + size_t(iy) * size_t(w) + ix;
    const float* q = box.height() > 1 ? p + w : p;
    const int r = w > 1;
    const float low = p[0] + fx * (p[r] - p[0]), high = q[0] + fx * (q[r] - q[0]);
    const float v = low + fy * (high - low);
    if (cx == x && cy == y) return v;
    return beyond(v, x, y);
  }

  /// The box is convex, so the distance grows at least by Pythagoras; beyond the domain nothing is known to end.
  float beyond(float v, float x, float y) const {
    const float nx = std::min(std::max(x, float(domain.x0)), float(domain.x1 - 1));
    const float ny = std::min(std::max(y, float(domain.y0)), float(domain.y1 - 1));
    const float ex = std::max(std::max(float(box.x0) - nx, nx - float(box.x1 - 1)), 0.0f) * pixel[0];
    const float ey = std::max(std::max(float(box.y0) - ny, ny - float(box.y1 - 1)), 0.0f) * pixel[1];
    const float e2 = ex * ex + ey * ey;
    return e2 <= 0 ? v : v < 0 ? -std::sqrt(v * v + e2) : v - std::sqrt(e2);
  }
};

}  // namespace slicemorph

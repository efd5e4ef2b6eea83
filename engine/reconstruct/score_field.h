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
      : values(score.values.data()), box(score.box), domain(stack.domain), pixel{stack.pixel[0], stack.pixel[1]} {}
  explicit operator bool() const { return values != nullptr; }

  float at(float x, float y) const {
    const float cx = std::min(std::max(x, float(box.x0)), float(box.x1 - 1));
    const float cy = std::min(std::max(y, float(box.y0)), float(box.y1 - 1));
    const int w = box.width();
    const int ix = std::max(std::min(int(cx) - box.x0, w - 2), 0), iy = std::max(std::min(int(cy) - box.y0, box.height() - 2), 0);
    const float fx = cx - float(ix + box.x0), fy = cy - float(iy + box.y0);
    const float* p = values + size_t(iy) * size_t(w) + ix;
    const float* q = box.height() > 1 ? p + w : p;
    const int r = w > 1;
    const float low = p[0] + fx * (p[r] - p[0]), high = q[0] + fx * (q[r] - q[0]);
    const float v = low + fy * (high - low);
    if (cx == x && cy == y) return v;
    return beyond(v, x, y);
  }

 private:
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

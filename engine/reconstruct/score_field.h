#pragma once

#include "engine/reconstruct/slice_scores.h"

#include <cmath>

namespace slicemorph {

/// Points of a plane, as pixels and fractions (0 to 1) of the way to the next pixel; all pixels are in `box`.
struct PlanePoints {
  std::vector<int> x, y;
  std::vector<float> fx, fy;
  PixelBox box;

  /// Sets `width` x `height` points, bilinear between four corners: those of points (0, 0), (width - 1, 0),
  /// (0, height - 1) and (width - 1, height - 1).
  void spread(const float* cornerX, const float* cornerY, int width, int height) {
    const size_t count = size_t(width) * size_t(height);
    x.resize(count), y.resize(count), fx.resize(count), fy.resize(count);
    const float across = 1 / std::max(1.0f, float(width - 1)), down = 1 / std::max(1.0f, float(height - 1));
    const auto [lowX, highX] = std::minmax({cornerX[0], cornerX[1], cornerX[2], cornerX[3]});
    const auto [lowY, highY] = std::minmax({cornerY[0], cornerY[1], cornerY[2], cornerY[3]});
    box = {int(std::floor(lowX)), int(std::floor(lowY)), int(std::floor(highX)) + 1,
           int(std::floor(highY)) + 1};
    for (int j = 0; j < height; ++j) {
      const float f = down * float(j);
      const float x0 = cornerX[0] + f * (cornerX[2] - cornerX[0]),
                  x1 = cornerX[1] + f * (cornerX[3] - cornerX[1]);
      const float y0 = cornerY[0] + f * (cornerY[2] - cornerY[0]),
                  y1 = cornerY[1] + f * (cornerY[3] - cornerY[1]);
      const size_t row = size_t(j) * size_t(width);
      split({x0, across * (x1 - x0), lowX, highX}, width, &x[row], &fx[row]);
      split({y0, across * (y1 - y0), lowY, highY}, width, &y[row], &fy[row]);
    }
  }

 private:
  struct Line {
    float from, step, low, high;
  };
  static void split(const Line& line, int count, int* whole, float* part) {
    for (int i = 0; i < count; ++i) {
      const float at = std::min(std::max(line.from + line.step * float(i), line.low), line.high);
      const int cut = int(at), down = cut - (float(cut) > at);
      whole[i] = down, part[i] = at - float(down);
    }
  }
};

/// A label's score at any point of its plane (pixels): bilinear within its box, extrapolated as a distance
/// beyond it.
struct ScoreField {
  const float* values = nullptr;
  PixelBox box;
  PixelBox domain;
  float pixel[2] = {1, 1};

  ScoreField() = default;
  ScoreField(const LabelScore& score, const ScoreStack& stack)
      : values(score.values.data()),
        box(score.box),
        domain(stack.domain),
        pixel{stack.pixel[0], stack.pixel[1]},
        corner{float(score.box.x0), float(score.box.y0)},
        last{float(score.box.width() - 1), float(score.box.height() - 1)},
        row(size_t(score.box.width())) {}
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

  /// Evaluates `at` for many points.
  void read(const PlanePoints& points, float* to) const {
    const size_t count = points.x.size();
    if (points.box.x0 < box.x0 || points.box.y0 < box.y0 || points.box.x1 >= box.x1 ||
        points.box.y1 >= box.y1)
      return readRim(points, to);
    const int stride = int(row), *px = points.x.data(), *py = points.y.data();
    const float *fx = points.fx.data(), *fy = points.fy.data();
    const float* origin = values - (std::ptrdiff_t(box.y0) * stride + box.x0);
    for (size_t i = 0; i < count; ++i) {
      const float* p = origin + (std::ptrdiff_t(py[i]) * stride + px[i]);
      const float* q = p + stride;
      const float low = p[0] + fx[i] * (p[1] - p[0]), high = q[0] + fx[i] * (q[1] - q[0]);
      to[i] = low + fy[i] * (high - low);
    }
  }

 private:
  /// The box as floats: its first pixel, and the offset from there to the last one.
  float corner[2] = {0, 0}, last[2] = {0, 0};
  size_t row = 0;

  void readRim(const PlanePoints& points, float* to) const {
    const int w = box.width(), right = w > 1, below = box.height() > 1 ? w : 0;
    const int lastX = std::max(w - 2, 0), lastY = std::max(box.height() - 2, 0);
    for (size_t i = 0; i < points.x.size(); ++i) {
      const int x = points.x[i] - box.x0, y = points.y[i] - box.y0;
      const int ix = std::min(std::max(x, 0), lastX), iy = std::min(std::max(y, 0), lastY);
      const float fx = x < 0       ? 0
                       : x > lastX ? 1
                                   : points.fx[i],
                  fy = y < 0       ? 0
                       : y > lastY ? 1
                                   : points.fy[i];
      const float *p = values + (std::ptrdiff_t(iy) * w + ix), *q = p + below;
      const float low = p[0] + fx * (p[right] - p[0]), high = q[0] + fx * (q[right] - q[0]);
      to[i] = low + fy * (high - low);
    }
    for (size_t i = 0; i < points.x.size(); ++i)
      to[i] = beyond(to[i], float(points.x[i]) + points.fx[i], float(points.y[i]) + points.fy[i]);
  }

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

  /// The label is inside its box, which is convex, so the distance outside grows at least by Pythagoras.
  /// Beyond the domain the label may continue, so the distance there does not grow.
  float beyond(float v, float x, float y) const {
    const float nx = std::min(std::max(x, float(domain.x0)), float(domain.x1 - 1));
    const float ny = std::min(std::max(y, float(domain.y0)), float(domain.y1 - 1));
    const float ex = std::max(std::max(float(box.x0) - nx, nx - float(box.x1 - 1)), 0.0f) * pixel[0];
    const float ey = std::max(std::max(float(box.y0) - ny, ny - float(box.y1 - 1)), 0.0f) * pixel[1];
    const float e2 = ex * ex + ey * ey;
    const float outside = v < 0 ? v * v : 0;
    return (v < 0 ? 0 : v) - std::sqrt(outside + e2);
  }
};

}  // namespace slicemorph

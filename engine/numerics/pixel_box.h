#pragma once

#include <algorithm>
#include <cstddef>

namespace slicemorph {

/// Half-open rectangle of pixels, [x0, x1) x [y0, y1).
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  size_t count() const { return empty() ? 0 : size_t(width()) * size_t(height()); }
  size_t index(int x, int y) const { return size_t(y - y0) * size_t(width()) + size_t(x - x0); }
  bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  PixelBox grown(int by) const { return {x0 - by, y0 - by, x1 + by, y1 + by}; }
  void add(int x, int y) {
    if (empty()) *this = {x, y, x + 1, y + 1};
    x0 = std::min(x0, x), y0 = std::min(y0, y), x1 = std::max(x1, x + 1), y1 = std::max(y1, y + 1);
  }
};

inline PixelBox intersection(const PixelBox& a, const PixelBox& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

inline PixelBox hull(const PixelBox& a, const PixelBox& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

}  // namespace slicemorph

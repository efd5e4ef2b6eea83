#include "engine/reconstruct/grey_motion.h"

#include "engine/numerics/parallel_each.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slicemorph {

namespace {

constexpr int kLeastSide = 12;  ///< pixels of the coarsest image
constexpr int kSteps = 6;       ///< least-squares steps on each size of the images
// Measured on every fourth or sixth slice of three heads (CT_AVM, ch2bet along two axes): windows of 3 and less weight of
// standing still are worse than no motion, these are better (rms 17.6, 6.9, 8.9 against 17.9, 7.1, 8.9).
constexpr int kWindow =
    10;  ///< half width of the windows' running means, pixels; three of them, nearly a Gaussian
constexpr float kLongestStep = 1;  ///< pixels of the image's own size
/// Weight of standing still: of the mean squared gradient of the whole slice. Where there is less to hold on to than
/// that, the motion is that of the surroundings, found on coarser images.
constexpr float kStandStill = 1;
/// Values of larger size are marks ("no measurement") rather than measurements, and their squares are no numbers any more.
constexpr float kMostValue = 1e15f;
/// The motion is kept where it leaves less than this share of the difference without motion.
constexpr float kGained = 0.7f;

GreySlice half(const GreySlice& s) {
  GreySlice out{(s.width + 1) / 2, (s.height + 1) / 2, {}};
  out.values.resize(size_t(out.width) * size_t(out.height));
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      float sum = 0, weight = 0;
      for (int v = -1; v <= 1; ++v)
        for (int u = -1; u <= 1; ++u) {
          const float w = (u ? 1.0f : 2.0f) * (v ? 1.0f : 2.0f);
          const int px = std::clamp(2 * x + u, 0, s.width - 1), py = std::clamp(2 * y + v, 0, s.height - 1);
          sum += w * s.values[size_t(py) * size_t(s.width) + size_t(px)], weight += w;
        }
      out.values[size_t(y) * size_t(out.width) + size_t(x)] = sum / weight;
    }
  return out;
}

/// A running mean over 2 kWindow + 1 values along a row, beyond whose ends there is nothing.
void runningMean(float* v, int n, std::ptrdiff_t stride, std::vector<float>& line) {
  line.resize(size_t(n));
  for (int i = 0; i < n; ++i) line[size_t(i)] = v[i * stride];
  double sum = 0;
  for (int i = 0; i < std::min(kWindow, n); ++i) sum += double(line[size_t(i)]);
  for (int i = 0; i < n; ++i) {
    if (i + kWindow < n) sum += double(line[size_t(i + kWindow)]);
    if (i - kWindow - 1 >= 0) sum -= double(line[size_t(i - kWindow - 1)]);
    v[i * stride] = float(sum / (2 * kWindow + 1));
  }
}

void overWindows(std::vector<float>& v, int width, int height) {
  std::vector<float> line;
  for (int pass = 0; pass < 3; ++pass) {
    for (int y = 0; y < height; ++y) runningMean(&v[size_t(y) * size_t(width)], width, 1, line);
    for (int x = 0; x < width; ++x) runningMean(&v[size_t(x)], height, width, line);
  }
}

SliceMotion still(int width, int height) {
  SliceMotion motion;
  motion.nx = std::max(2, width), motion.ny = std::max(2, height);
  motion.x.assign(size_t(motion.nx) * size_t(motion.ny), 0), motion.y = motion.x;
  return motion;
}

SliceMotion doubled(const SliceMotion& coarse, int width, int height) {
  SliceMotion motion = still(width, height);
  for (int y = 0; y < motion.ny; ++y)
    for (int x = 0; x < motion.nx; ++x) {
      const SliceMotion::Vector v = coarse.at(0.5f * float(x), 0.5f * float(y));
      const size_t n = size_t(y) * size_t(motion.nx) + size_t(x);
      motion.x[n] = 2 * v.x, motion.y[n] = 2 * v.y;
    }
  return motion;
}

/// Difference of the slices' values where the motion takes a point that is at (x, y) half way.
float difference(const GreySlice& a, const GreySlice& b, float x, float y, float vx, float vy) {
  return b.at(x + .5f * vx, y + .5f * vy) - a.at(x - .5f * vx, y - .5f * vy);
}

void step(const GreySlice& a, const GreySlice& b, SliceMotion& motion) {
  const size_t count = size_t(motion.nx) * size_t(motion.ny);
  std::array<std::vector<float>, 5> normal;
  for (auto& one : normal) one.assign(count, 0);
  double steepness = 0;
  for (int y = 0; y < motion.ny; ++y)
    for (int x = 0; x < motion.nx; ++x) {
      const size_t n = size_t(y) * size_t(motion.nx) + size_t(x);
      const float vx = .5f * motion.x[n], vy = .5f * motion.y[n], px = float(x), py = float(y);
      const float ax = px - vx, ay = py - vy, bx = px + vx, by = py + vy;
      const float gx = .25f * (a.at(ax + 1, ay) - a.at(ax - 1, ay) + b.at(bx + 1, by) - b.at(bx - 1, by));
      const float gy = .25f * (a.at(ax, ay + 1) - a.at(ax, ay - 1) + b.at(bx, by + 1) - b.at(bx, by - 1));
      const float r = b.at(bx, by) - a.at(ax, ay);
      normal[0][n] = gx * gx, normal[1][n] = gx * gy, normal[2][n] = gy * gy;
      normal[3][n] = -gx * r, normal[4][n] = -gy * r;
      steepness += double(gx * gx + gy * gy);
    }
  for (auto& one : normal) overWindows(one, motion.nx, motion.ny);
  const float rest = kStandStill * float(steepness / double(count));
  if (!(rest > 0)) return;
  std::vector<float> dx(count), dy(count);
  for (size_t n = 0; n < count; ++n) {
    const float xx = normal[0][n] + rest, yy = normal[2][n] + rest, xy = normal[1][n];
    const float det = xx * yy - xy * xy;
    dx[n] = (yy * normal[3][n] - xy * normal[4][n]) / det;
    dy[n] = (xx * normal[4][n] - xy * normal[3][n]) / det;
    const float length = std::sqrt(dx[n] * dx[n] + dy[n] * dy[n]);
    if (length > kLongestStep) dx[n] *= kLongestStep / length, dy[n] *= kLongestStep / length;
  }
  for (size_t n = 0; n < count; ++n) motion.x[n] += dx[n], motion.y[n] += dy[n];
}

/// Takes the motion back where it gains nothing, smoothly.
void keepGains(const GreySlice& a, const GreySlice& b, SliceMotion& motion) {
  const size_t count = size_t(motion.nx) * size_t(motion.ny);
  std::vector<float> moved(count), unmoved(count), share(count);
  for (int y = 0; y < motion.ny; ++y)
    for (int x = 0; x < motion.nx; ++x) {
      const size_t n = size_t(y) * size_t(motion.nx) + size_t(x);
      const float with = difference(a, b, float(x), float(y), motion.x[n], motion.y[n]),
                  without = difference(a, b, float(x), float(y), 0, 0);
      moved[n] = with * with, unmoved[n] = without * without;
    }
  overWindows(moved, motion.nx, motion.ny), overWindows(unmoved, motion.nx, motion.ny);
  for (size_t n = 0; n < count; ++n) share[n] = moved[n] <= kGained * unmoved[n] ? 1.0f : 0.0f;
  overWindows(share, motion.nx, motion.ny);
  for (size_t n = 0; n < count; ++n) {
    const float s = std::clamp(2 * share[n], 0.0f, 1.0f);
    motion.x[n] *= s, motion.y[n] *= s;
  }
}

/// The slice with the least value in place of what is no number and of marks.
GreySlice measured(const GreySlice& slice) {
  const auto isMeasured = [](float v) { return std::abs(v) <= kMostValue; };
  float least = kMostValue;
  for (const float v : slice.values)
    if (isMeasured(v)) least = std::min(least, v);
  GreySlice result = slice;
  for (float& v : result.values)
    if (!isMeasured(v)) v = least == kMostValue ? 0 : least;
  return result;
}

}  // namespace

float GreySlice::at(float x, float y) const {
  const float cx = std::clamp(x, 0.0f, float(width - 1)), cy = std::clamp(y, 0.0f, float(height - 1));
  const int ix = std::min(int(cx), std::max(width - 2, 0)), iy = std::min(int(cy), std::max(height - 2, 0));
  const float fx = cx - float(ix), fy = cy - float(iy);
  const float* p = &values[size_t(iy) * size_t(width) + size_t(ix)];
  const float* q = height > 1 ? p + width : p;
  const int r = width > 1;
  const float low = p[0] + fx * (p[r] - p[0]), high = q[0] + fx * (q[r] - q[0]);
  return low + fy * (high - low);
}

SliceMotion greyMotion(const GreySlice& a, const GreySlice& b) {
  std::vector<std::array<GreySlice, 2>> sizes{{measured(a), measured(b)}};
  while (std::min(sizes.back()[0].width, sizes.back()[0].height) >= 2 * kLeastSide)
    sizes.push_back({half(sizes.back()[0]), half(sizes.back()[1])});
  SliceMotion motion = still(sizes.back()[0].width, sizes.back()[0].height);
  for (size_t level = sizes.size(); level-- > 0;) {
    const auto& [first, second] = sizes[level];
    if (level + 1 < sizes.size()) motion = doubled(motion, first.width, first.height);
    for (int k = 0; k < kSteps; ++k) step(first, second, motion);
  }
  keepGains(sizes[0][0], sizes[0][1], motion);
  return motion;
}

}  // namespace slicemorph

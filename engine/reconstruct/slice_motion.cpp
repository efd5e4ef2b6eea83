#include "engine/reconstruct/slice_motion.h"

#include <array>
#include <cmath>

namespace slicemorph {

namespace {

/// Distance between nodes, in pixels: finer than what moves together, coarse enough to be fast.
constexpr float kNodePixels = 4;
/// Half width of the first window in nodes, and at most a gap; it is halved from level to level.
constexpr float kWidest = 4;
constexpr int kLevels = 3, kRounds = 3;  // window sizes; least-squares steps with each
/// Weight of zero motion, relative to one label's border at every node of the window. So a border that only
/// one label has, or that matches badly, moves little, and blending the distances does the rest. Chosen by
/// hand, like kRoughBorder; both are guarded by label_slices_test.cpp.
constexpr float kRest = 4;
/// Additional weight of zero motion, times (pixel / gap)^2: borders are known to a pixel only, which matters
/// where the gap is only a few pixels.
constexpr float kRoughBorder = 20;
/// A node farther from a label's contour than this many times the window's reach is dropped for that label:
/// later windows reach less far.
constexpr float kAside = 1.5f;

/// Normal equations of one node: the matrix A (xx, xy, yy) and the right side (x, y), world units.
using Normal = std::array<float, 5>;

/// One pass of a running mean over 2 r + 1 nodes along a row; values beyond the ends count as 0.
void boxBlur(std::vector<Normal>& values, int nx, int ny, int r, bool alongX) {
  const int n = alongX ? nx : ny, rows = alongX ? ny : nx;
  const size_t stride = alongX ? 1 : size_t(nx), rowStride = alongX ? size_t(nx) : 1;
  std::vector<Normal> line;
  line.resize(size_t(n));
  const float scale = 1.0f / float(2 * r + 1);
  for (int row = 0; row < rows; ++row) {
    Normal* p = &values[size_t(row) * rowStride];
    for (int i = 0; i < n; ++i) line[size_t(i)] = p[size_t(i) * stride];
    Normal sum{};
    for (int i = 0; i < std::min(r, n); ++i)
      for (size_t c = 0; c < 5; ++c) sum[c] += line[size_t(i)][c];
    for (int i = 0; i < n; ++i) {
      if (i + r < n)
        for (size_t c = 0; c < 5; ++c) sum[c] += line[size_t(i + r)][c];
      if (i - r - 1 >= 0)
        for (size_t c = 0; c < 5; ++c) sum[c] -= line[size_t(i - r - 1)][c];
      for (size_t c = 0; c < 5; ++c) p[size_t(i) * stride][c] = sum[c] * scale;
    }
  }
}

/// One label on both planes, and the nodes near its contour.
struct Pair {
  ScoreField a, b;
  std::vector<int> nodes;
};

/// Adds one label's equations for a node's displacement. Returns the node's distance from the contour.
float addLabel(const Pair& pair, const float* pixel, float ax, float ay, float bx, float by, float reach,
               Normal& n) {
  const float sa = pair.a.at(ax, ay), sb = pair.b.at(bx, by), nearest = std::min(std::abs(sa), std::abs(sb));
  if (nearest > reach) return nearest;
  const float ca = std::min(std::max(sa, -reach), reach), cb = std::min(std::max(sb, -reach), reach);
  // Central differences over one pixel.
  const float gx =
      0.5f / pixel[0] *
      (pair.a.at(ax + .5f, ay) - pair.a.at(ax - .5f, ay) + pair.b.at(bx + .5f, by) - pair.b.at(bx - .5f, by));
  const float gy =
      0.5f / pixel[1] *
      (pair.a.at(ax, ay + .5f) - pair.a.at(ax, ay - .5f) + pair.b.at(bx, by + .5f) - pair.b.at(bx, by - .5f));
  const float r = cb - ca;
  n[0] += gx * gx, n[1] += gx * gy, n[2] += gy * gy, n[3] -= gx * r, n[4] -= gy * r;
  return nearest;
}

/// All nodes of the label's box, and `margin` nodes around it.
void findNodes(Pair& pair, const SliceMotion& motion, int margin) {
  const PixelBox box = hull(pair.a.box, pair.b.box);
  const auto nodeAt = [&](int p, int d) { return int((float(p) - motion.origin[d]) / motion.spacing[d]); };
  const int i0 = std::max(0, nodeAt(box.x0, 0) - margin),
            i1 = std::min(motion.nx, nodeAt(box.x1, 0) + 2 + margin);
  const int j0 = std::max(0, nodeAt(box.y0, 1) - margin),
            j1 = std::min(motion.ny, nodeAt(box.y1, 1) + 2 + margin);
  for (int j = j0; j < j1; ++j)
    for (int i = i0; i < i1; ++i) pair.nodes.push_back(j * motion.nx + i);
}

/// The labels present on both planes.
std::vector<Pair> commonLabels(const ScoreStack& stack, const ScorePlane& a, const ScorePlane& b) {
  std::vector<Pair> pairs;
  for (size_t i = 0, j = 0; i < a.labels.size() && j < b.labels.size();) {
    if (a.labels[i].label < b.labels[j].label)
      ++i;
    else if (b.labels[j].label < a.labels[i].label)
      ++j;
    else
      pairs.push_back({ScoreField(a.labels[i++], stack), ScoreField(b.labels[j++], stack), {}});
  }
  return pairs;
}

/// A motion of zero, on nodes `step` world units apart that cover all labels.
SliceMotion motionOver(const std::vector<Pair>& pairs, const ScoreStack& stack, float step) {
  PixelBox busy;
  for (const Pair& pair : pairs) busy = hull(busy, hull(pair.a.box, pair.b.box));
  busy = busy.grown(1);
  SliceMotion motion;
  for (int d = 0; d < 2; ++d) motion.spacing[d] = std::max(1.0f, step / stack.pixel[d]);
  motion.origin[0] = float(busy.x0), motion.origin[1] = float(busy.y0);
  motion.nx = std::max(2, int(float(busy.width()) / motion.spacing[0]) + 2);
  motion.ny = std::max(2, int(float(busy.height()) / motion.spacing[1]) + 2);
  const size_t nodes = size_t(motion.nx) * size_t(motion.ny);
  motion.x.assign(nodes, 0), motion.y.assign(nodes, 0);
  return motion;
}

/// Sums the equations of all labels at every node within `reach` of their contours; nodes far from a label's
/// contour are dropped for that label.
void addLabels(std::vector<Pair>& pairs, const ScoreStack& stack, const SliceMotion& motion, float reach,
               std::vector<Normal>& normal) {
  std::fill(normal.begin(), normal.end(), Normal{});
  for (Pair& pair : pairs) {
    size_t kept = 0;
    for (const int node : pair.nodes) {
      const size_t k = size_t(node);
      const float px = motion.origin[0] + float(node % motion.nx) * motion.spacing[0];
      const float py = motion.origin[1] + float(node / motion.nx) * motion.spacing[1];
      const float vx = .5f * motion.x[k], vy = .5f * motion.y[k];
      if (addLabel(pair, stack.pixel, px - vx, py - vy, px + vx, py + vy, reach, normal[k]) <= kAside * reach)
        pair.nodes[kept++] = node;
    }
    pair.nodes.resize(kept);
  }
}

/// One least-squares step, no longer than `limit` world units. `rest`: weight of zero motion.
void stepMotion(const std::vector<Normal>& normal, const ScoreStack& stack, float rest, float limit,
                SliceMotion& motion) {
  for (size_t k = 0; k < normal.size(); ++k) {
    const Normal& n = normal[k];
    const float xx = n[0] + rest, yy = n[2] + rest, det = xx * yy - n[1] * n[1];
    float dx = (yy * n[3] - n[1] * n[4]) / det, dy = (xx * n[4] - n[1] * n[3]) / det;
    const float l = std::sqrt(dx * dx + dy * dy);
    if (l > limit) dx *= limit / l, dy *= limit / l;
    motion.x[k] += dx / stack.pixel[0], motion.y[k] += dy / stack.pixel[1];
  }
}

}  // namespace

SliceMotion findMotion(const ScoreStack& stack, size_t a) {
  const ScorePlane &pa = stack.planes[a], &pb = stack.planes[a + 1];
  std::vector<Pair> pairs = commonLabels(stack, pa, pb);
  if (pairs.empty()) return {};
  const float gap = float(pb.position - pa.position), pixel = std::max(stack.pixel[0], stack.pixel[1]);
  const float spacing = kNodePixels * pixel, rough = pixel / gap;
  SliceMotion motion = motionOver(pairs, stack, spacing);
  std::vector<Normal> normal(motion.x.size());
  float sigma = std::min(gap, kWidest * spacing);
  for (Pair& pair : pairs) findNodes(pair, motion, int(sigma / spacing) + 1);
  for (int level = 0; level < kLevels; ++level, sigma *= 0.5f) {
    const int r = std::max(1, int(std::lround(sigma / spacing)));
    // Fine windows hold little evidence, and what they add to coarse ones is mostly noise.
    const float rest = kRest * (level < 2 ? 1 : 2) + kRoughBorder * rough * rough;
    for (int round = 0; round < kRounds; ++round) {
      addLabels(pairs, stack, motion, sigma, normal);
      for (int pass = 0; pass < 2; ++pass)
        for (bool alongX : {true, false}) boxBlur(normal, motion.nx, motion.ny, r, alongX);
      stepMotion(normal, stack, rest, sigma, motion);
    }
  }
  return motion;
}

}  // namespace slicemorph

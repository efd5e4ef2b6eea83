#include "engine/reconstruct/slice_moment.h"

namespace slicemorph {

namespace {

/// Scores level off at this share of the gap's length. Chosen by hand; guarded by label_slices_test.cpp.
constexpr float kLevel = 0.85f;
/// Largest change of a slope by the cubic, in gaps per gap: more indicates a label that jumps, not one that
/// bends. Chosen by hand; guarded by label_slices_test.cpp.
constexpr float kBend = 0.7f;
/// Slopes over a gap of few pixels are mostly rounding to pixels: they are weighted by 1 / (1 + kRoughSlope
/// (pixel / gap)^2).
constexpr float kRoughSlope = 0.5f;
/// Scores that differ by less than this share of the level are a tie, and where a gap is a few pixels so are those that
/// differ by less than kRoughDraw (pixel / gap)^2 pixels: for a gap of two pixels, a tenth of a pixel in all. Measured on
/// brain atlases (natbrainlab, brodmann): from a 60th to an 8th of a pixel it makes no difference of 0.001.
constexpr float kDraw = 0.01f, kRoughDraw = 0.3f;

/// Share of the bending that a cubic through the motions of three gaps has: they are known so well only. Measured on
/// torsoLabel and aal at every second, fourth and eighth slice: from 0.5 to 1 it makes no difference of 0.001.
constexpr float kPathBend = 0.5f;

}  // namespace

Moment momentAt(const ScoreStack& stack, double position) {
  const auto& planes = stack.planes;
  Moment m;
  while (m.gap + 2 < planes.size() && planes[m.gap + 1].position <= position) ++m.gap;
  const size_t g = m.gap;
  const float h = float(planes[g + 1].position - planes[g].position);
  const float t = m.t = float((position - planes[g].position) / double(h));
  m.level = kLevel * h, m.limit = kBend * h * t * (1 - t);
  const float rough = std::max(stack.pixel[0], stack.pixel[1]) / h,
              trust = 1 / (1 + kRoughSlope * rough * rough);
  const float pixel = std::min(stack.pixel[0], stack.pixel[1]);
  m.draw = kDraw * m.level + kRoughDraw * pixel * (pixel / h) * (pixel / h);
  m.cubic[1] = 1 - t, m.cubic[2] = t;
  // Hermite's cubic is the linear blend plus u (slope at a - chord) - v (slope at b - chord). A slope is that
  // of the parabola through three planes, for any gaps.
  const auto bend = [&](double gapBeyond, float by, int side, int beyond, int here, int there) {
    const float k = float(gapBeyond), a = by * h / (k + h), q = h / k;
    m.cubic[beyond] -= a * q, m.cubic[here] += a * (q + 1), m.cubic[there] -= a;
    m.path.weight[side] = kPathBend * a, m.path.ratio[side] = q;
  };
  if ((m.before = g > 0))
    bend(planes[g].position - planes[g - 1].position, trust * t * (1 - t) * (1 - t), 0, 0, 1, 2);
  if ((m.after = g + 2 < planes.size()))
    bend(planes[g + 2].position - planes[g + 1].position, trust * t * t * (1 - t), 1, 3, 2, 1);
  return m;
}

}  // namespace slicemorph

#include "engine/reconstruct/slice_scores.h"

#include "engine/errors.h"
#include "engine/reconstruct/score_field.h"
#include "engine/reconstruct/slice_motion.h"

#include <tbb/parallel_for.h>

#include <cstring>
extern double knob[40];

namespace slicemorph {

namespace {

constexpr int kTile = 8;

/// One label in one gap: its fields on the planes before, at, at and after it.
struct GapLabel {
  int label;
  ScoreField plane[4];
  float depth[2] = {0, 0};  ///< greatest score on either plane
  PixelBox box;
};

struct Gap {
  std::vector<GapLabel> labels;
  SliceMotion motion;
};

const LabelScore* find(const ScorePlane& plane, int label) {
  const auto it = std::lower_bound(plane.labels.begin(), plane.labels.end(), label, [](const LabelScore& s, int l) { return s.label < l; });
  return it != plane.labels.end() && it->label == label ? &*it : nullptr;
}

/// Where the pixels of a tile lie on the four planes.
struct TilePoints {
  PixelBox box;
  float x[4][kTile * kTile], y[4][kTile * kTile];
};

}  // namespace

struct SliceScores::Plan {
  ScoreStack stack;
  std::vector<Gap> gaps;

  size_t gapAt(double position) const {
    size_t g = 0;
    while (g + 2 < stack.planes.size() && stack.planes[g + 1].position <= position) ++g;
    return g;
  }

  void place(size_t g, float t, TilePoints& tile) const {
    const SliceMotion& motion = gaps[g].motion;
    size_t i = 0;
    for (int y = tile.box.y0; y < tile.box.y1; ++y)
      for (int x = tile.box.x0; x < tile.box.x1; ++x, ++i) {
        SliceMotion::Vector v = motion.at(float(x), float(y));
        v = motion.at(float(x) - (t - .5f) * v.x, float(y) - (t - .5f) * v.y);
        tile.x[1][i] = float(x) - t * v.x, tile.y[1][i] = float(y) - t * v.y;
        tile.x[2][i] = float(x) + (1 - t) * v.x, tile.y[2][i] = float(y) + (1 - t) * v.y;
        SliceMotion::Vector u = g > 0 ? gaps[g - 1].motion.at(tile.x[1][i], tile.y[1][i]) : SliceMotion::Vector{0, 0};
        tile.x[0][i] = tile.x[1][i] - u.x, tile.y[0][i] = tile.y[1][i] - u.y;
        u = g + 1 < gaps.size() ? gaps[g + 1].motion.at(tile.x[2][i], tile.y[2][i]) : SliceMotion::Vector{0, 0};
        tile.x[3][i] = tile.x[2][i] + u.x, tile.y[3][i] = tile.y[2][i] + u.y;
      }
  }

  struct Weights4 {
    float cubic[4], t, limit, c;
    bool before, after;
  };

  Weights4 weightsAt(float t, const float* h) const {
    Weights4 w{{0, 1 - t, t, 0}, t, float(knob[12]) * h[1] * t * (1 - t), std::max(float(knob[20]) * h[1], float(knob[23]) * std::max(stack.pixel[0], stack.pixel[1])), h[0] > 0, h[2] > 0};
    const float u = t * (1 - t) * (1 - t), v = t * t * (1 - t);
    // Hermite: linear + u (ma - d) - v (mb - d), slopes by the parabola through three planes
    if (h[0] > 0) {  // ma - d = (d0 - d) h1 / (h0 + h1), d0 = (s1 - s0) h1 / h0
      const float a = u * h[1] / (h[0] + h[1]), q = h[1] / h[0];
      w.cubic[0] -= a * q, w.cubic[1] += a * (q + 1), w.cubic[2] -= a;
    }
    if (h[2] > 0) {  // mb - d = (d1 - d) h1 / (h1 + h2), d1 = (s3 - s2) h1 / h2
      const float a = v * h[1] / (h[1] + h[2]), q = h[1] / h[2];
      w.cubic[3] -= a * q, w.cubic[2] += a * (q + 1), w.cubic[1] -= a;
    }
    return w;
  }

  /// Fills in the planes where the label is not.
  void complete(const GapLabel& l, const Weights4& w, float* s) const {
    const float k = float(knob[10]);
    if (!l.plane[2]) s[2] = s[1] - k * l.depth[0];
    if (!l.plane[1]) s[1] = s[2] - k * l.depth[1];
    if (w.before && !l.plane[0]) s[0] = l.plane[1] ? s[1] - k * l.depth[0] : 2 * s[1] - s[2];
    if (w.after && !l.plane[3]) s[3] = l.plane[2] ? s[2] - k * l.depth[1] : 2 * s[2] - s[1];
    for (int i = 0; i < 4; ++i) s[i] = s[i] / std::sqrt(1 + s[i] * s[i] / (w.c * w.c));
  }

  float blend(const Weights4& w, const float* s) const {
    const float linear = s[1] + w.t * (s[2] - s[1]);
    const float cubic = w.cubic[0] * s[0] + w.cubic[1] * s[1] + w.cubic[2] * s[2] + w.cubic[3] * s[3];
    return std::min(std::max(cubic, linear - w.limit), linear + w.limit);
  }

  void read(const GapLabel& l, const Weights4& w, const TilePoints& tile, size_t i, float* s) const {
    s[0] = s[3] = 0;
    for (int k = 0; k < 4; ++k)
      if (l.plane[k]) s[k] = l.plane[k].at(tile.x[k][i], tile.y[k][i]);
  }

  float score(const GapLabel& l, const TilePoints& tile, size_t i, const Weights4& w) const {
    float s[4];
    read(l, w, tile, i, s);
    complete(l, w, s);
    return blend(w, s);
  }

  /// Least and greatest the label's score can be within `reach` of a point.
  void bounds(const GapLabel& l, const TilePoints& tile, const Weights4& w, float reach, float& low, float& high) const {
    float s[4], lo[4], hi[4];
    read(l, w, tile, 0, s);
    for (int k = 0; k < 4; ++k) lo[k] = s[k] - reach, hi[k] = s[k] + reach;
    complete(l, w, lo), complete(l, w, hi);
    float cl = 0, ch = 0;
    for (int k = 0; k < 4; ++k) {
      cl += w.cubic[k] * (w.cubic[k] > 0 ? lo[k] : hi[k]);
      ch += w.cubic[k] * (w.cubic[k] > 0 ? hi[k] : lo[k]);
    }
    const float ll = lo[1] + w.t * (lo[2] - lo[1]), lh = hi[1] + w.t * (hi[2] - hi[1]);
    low = std::max(std::min(cl, ll + w.limit), ll - w.limit);
    high = std::min(std::max(ch, lh - w.limit), lh + w.limit);
  }
};

SliceScores::SliceScores(ScoreStack stack) : plan_(std::make_unique<Plan>()) {
  if (stack.planes.size() < 2) throw InputError("at least two planes are needed, got " + std::to_string(stack.planes.size()));
  plan_->stack = std::move(stack);
  const ScoreStack& s = plan_->stack;
  plan_->gaps.resize(s.planes.size() - 1);
  tbb::parallel_for(size_t(0), plan_->gaps.size(), [&](size_t g) {
    Gap& gap = plan_->gaps[g];
    std::vector<int> labels;
    for (size_t k = g; k < g + 2; ++k)
      for (const LabelScore& l : s.planes[k].labels) labels.push_back(l.label);
    std::sort(labels.begin(), labels.end());
    labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
    for (int label : labels) {
      GapLabel l;
      l.label = label;
      for (size_t k = 0; k < 4; ++k)
        if (g + k >= 1 && g + k - 1 < s.planes.size())
          if (const LabelScore* f = find(s.planes[g + k - 1], label)) {
            l.plane[k] = ScoreField(*f, s);
            if (k == 1 || k == 2) l.box = hull(l.box, f->box), l.depth[k - 1] = *std::max_element(f->values.begin(), f->values.end());
          }
      gap.labels.push_back(l);
    }
    gap.motion = findMotion(s, g);
  });
}

SliceScores::~SliceScores() = default;
const ScoreStack& SliceScores::stack() const { return plan_->stack; }

std::vector<int> SliceScores::labelsAt(double position, const PixelBox& box) const {
  const size_t g = plan_->gapAt(position);
  const Gap& gap = plan_->gaps[g];
  const auto& planes = plan_->stack.planes;
  const float t = float((position - planes[g].position) / (planes[g + 1].position - planes[g].position));
  float h[3] = {0, 0, 0};
  for (size_t k = 0; k < 3; ++k)
    if (g + k >= 1 && g + k < planes.size()) h[k] = float(planes[g + k].position - planes[g + k - 1].position);
  std::vector<int> out(box.count());
  TilePoints tile;
  float best[kTile * kTile];
  int win[kTile * kTile];
  const float px = plan_->stack.pixel[0], py = plan_->stack.pixel[1];
  int tx = kTile, ty = kTile;
  while (tx > 1 && float(tx) * px >= 2 * float(ty) * py) tx /= 2, ty *= 2;
  while (ty > 1 && float(ty) * py >= 2 * float(tx) * px) ty /= 2, tx *= 2;
  const float reach = float(knob[14]) * 0.5f * std::sqrt(float(tx * tx) * px * px + float(ty * ty) * py * py);
  const Plan::Weights4 w4 = plan_->weightsAt(t, h);
  std::vector<float> centre(gap.labels.size());
  TilePoints middle;
  for (int y = box.y0; y < box.y1; y += ty)
    for (int x = box.x0; x < box.x1; x += tx) {
      tile.box = intersection({x, y, x + tx, y + ty}, box);
      const size_t n = tile.box.count(), w = size_t(tile.box.width());
      const int mx = (tile.box.x0 + tile.box.x1) / 2, my = (tile.box.y0 + tile.box.y1) / 2;
      middle.box = {mx, my, mx + 1, my + 1};
      plan_->place(g, t, middle);
      float most = -1e30f;
      for (size_t k = 0; k < gap.labels.size(); ++k) {
        float low;
        plan_->bounds(gap.labels[k], middle, w4, reach, low, centre[k]);
        most = std::max(most, low - 1e-4f * w4.c);  // rounding must not rule everyone out
      }
      size_t rivals = 0, only = 0;
      for (size_t k = 0; k < gap.labels.size(); ++k)
        if (centre[k] >= most) ++rivals, only = k;
      if (rivals == 1) {
        for (size_t i = 0; i < n; ++i) out[box.index(tile.box.x0 + int(i % w), tile.box.y0 + int(i / w))] = gap.labels[only].label;
        continue;
      }
      plan_->place(g, t, tile);
      std::fill(best, best + n, -1e30f);
      for (size_t k = 0; k < gap.labels.size(); ++k) {
        if (centre[k] < most) continue;
        for (size_t i = 0; i < n; ++i) {
          const float v = plan_->score(gap.labels[k], tile, i, w4);
          if (v > best[i]) best[i] = v, win[i] = gap.labels[k].label;
        }
      }
      for (size_t i = 0; i < n; ++i)
        out[box.index(tile.box.x0 + int(i % w), tile.box.y0 + int(i / w))] = win[i];
    }
  return out;
}

}  // namespace slicemorph

#include "engine/reconstruct/slice_scores.h"

#include "engine/errors.h"
#include "engine/reconstruct/regions.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <string>

namespace slicemorph {

namespace {

constexpr int kLeaf = 16;  ///< pixels of a cell that is not cut any further
/// Scores level off at a gap's length: how far away a contour is says nothing about what comes within one gap.
constexpr float kLevel = 0.85f;
/// The cubic may change a slope by this share of a gap per gap: more is a label that jumps, not one that bends.
constexpr float kBend = 0.7f;
/// Slopes over a gap of few pixels are mostly the pixels' rounding: they count 1 / (1 + kRough (pixel / gap)^2).
constexpr float kRough = 0.5f;
/// A label that is not on the next plane lies this many times its depth outside of there.
constexpr float kEnding = 3;
/// A lead of less than this share of the level is a draw: at one gap of two pixels, a 60th of a pixel.
constexpr float kDraw = 0.01f;
/// Room for how much the motion stretches a tile.
constexpr float kStretch = 1.2f;

/// One label in one gap: its fields on the planes before, at, at and after it.
struct GapLabel {
  int label = 0;
  ScoreField plane[4];
  float depth[2] = {0, 0};  ///< greatest score on either plane
  PixelBox box;             ///< holds it throughout
};

/// A region that goes to another place within a gap, where the smooth motion does not take it: it has the way before
/// all that stays.
struct Traveller {
  int label = 0;
  LabelScore a, b;
  float x = 0, y = 0;  ///< from a to b, pixels
  bool thin = false;   ///< less than two pixels thick: carried by whole pixels, or it would fall between them
  PixelBox box;
};

struct Gap {
  std::vector<GapLabel> labels;
  std::vector<Traveller> travellers;
  SliceMotion motion;
};

const LabelScore* find(const ScorePlane& plane, int label) {
  const auto it = std::lower_bound(plane.labels.begin(), plane.labels.end(), label,
                                   [](const LabelScore& s, int l) { return s.label < l; });
  return it != plane.labels.end() && it->label == label ? &*it : nullptr;
}

/// A position: its gap, the part of it, and the weights of the four planes' scores.
struct Moment {
  size_t gap = 0;
  float t = 0;
  float cubic[4] = {0, 0, 0, 0};
  float limit = 0;  ///< of the cubic's departure from the line
  float level = 0;
  bool before = false, after = false;  ///< whether there are planes 0 and 3
};

/// Where pixels lie on the four planes.
struct Places {
  float x[4], y[4];
};

Places between(const Places& a, const Places& b, float f) {
  Places p;
  for (int k = 0; k < 4; ++k) p.x[k] = a.x[k] + f * (b.x[k] - a.x[k]), p.y[k] = a.y[k] + f * (b.y[k] - a.y[k]);
  return p;
}

float levelOff(float s, float level) {
  const float q = s / level;
  return s / std::sqrt(1 + q * q);
}

/// Fills in the planes where the label is not, and levels off.
void complete(const GapLabel& l, const Moment& m, float* s) {
  if (!l.plane[2]) s[2] = s[1] - kEnding * l.depth[0];
  if (!l.plane[1]) s[1] = s[2] - kEnding * l.depth[1];
  if (m.before && !l.plane[0]) s[0] = l.plane[1] ? s[1] - kEnding * l.depth[0] : 2 * s[1] - s[2];
  if (m.after && !l.plane[3]) s[3] = l.plane[2] ? s[2] - kEnding * l.depth[1] : 2 * s[2] - s[1];
  for (int i = 0; i < 4; ++i) s[i] = levelOff(s[i], m.level);
}

void read(const GapLabel& l, const Places& p, float* s) {
  for (int k = 0; k < 4; ++k) s[k] = l.plane[k] ? l.plane[k].at(p.x[k], p.y[k]) : 0;
}

/// Anything up to `toBeat` stands for any other score up to it.
float scoreOf(const GapLabel& l, const Moment& m, const Places& p, float toBeat = -1e30f) {
  float s[4] = {0, 0, 0, 0};
  if (l.plane[1]) s[1] = l.plane[1].at(p.x[1], p.y[1]);
  if (l.plane[2]) s[2] = l.plane[2].at(p.x[2], p.y[2]);
  if (!l.plane[2]) s[2] = s[1] - kEnding * l.depth[0];
  if (!l.plane[1]) s[1] = s[2] - kEnding * l.depth[1];
  const float a = levelOff(s[1], m.level), linear = a + m.t * (levelOff(s[2], m.level) - a);
  if (linear + m.limit <= toBeat) return toBeat;
  if (m.before && l.plane[0]) s[0] = l.plane[0].at(p.x[0], p.y[0]);
  if (m.after && l.plane[3]) s[3] = l.plane[3].at(p.x[3], p.y[3]);
  complete(l, m, s);
  const float cubic = m.cubic[0] * s[0] + m.cubic[1] * s[1] + m.cubic[2] * s[2] + m.cubic[3] * s[3];
  return std::min(std::max(cubic, linear - m.limit), linear + m.limit);
}

/// What a label's score can be within `reach` of a point.
struct Bounds {
  float low, high;
};

Bounds boundsOf(const GapLabel& l, const Moment& m, const Places& p, float reach) {
  float s[4], lo[4], hi[4], cl = 0, ch = 0;
  read(l, p, s);
  for (int k = 0; k < 4; ++k) lo[k] = s[k] - reach, hi[k] = s[k] + reach;
  complete(l, m, lo), complete(l, m, hi);
  for (int k = 0; k < 4; ++k) {
    cl += m.cubic[k] * (m.cubic[k] > 0 ? lo[k] : hi[k]);
    ch += m.cubic[k] * (m.cubic[k] > 0 ? hi[k] : lo[k]);
  }
  const float ll = lo[1] + m.t * (lo[2] - lo[1]), lh = hi[1] + m.t * (hi[2] - hi[1]);
  const float spare = 1e-4f * m.level;  // rounding must not rule everyone out
  return {std::max(std::min(cl, ll + m.limit), ll - m.limit) - spare,
          std::min(std::max(ch, lh - m.limit), lh + m.limit)};
}

/// The labels that may win in a cell, on top of those of the cells that hold it.
struct Rivals {
  std::vector<const GapLabel*> labels;
  std::vector<float> highs;

  /// Adds those from `from` on that may win within `reach` of a point of `part`.
  void narrow(size_t from, const PixelBox& part, const Moment& m, const Places& p, float reach) {
    const size_t end = labels.size();
    float most = -1e30f;
    highs.clear();
    for (int anywhere = 0; anywhere < 2 && labels.size() == end; ++anywhere)  // where no label's box is, all compete
      for (size_t k = from; k < end; ++k) {
        const GapLabel* l = labels[k];
        if (!anywhere && intersection(l->box, part).empty()) continue;
        const Bounds b = boundsOf(*l, m, p, reach);
        most = std::max(most, b.low), labels.push_back(l), highs.push_back(b.high);
      }
    size_t kept = end;
    for (size_t k = end; k < labels.size(); ++k)
      if (highs[k - end] + kDraw * m.level >= most) labels[kept++] = labels[k];
    labels.resize(kept);
  }
};

float scoreOf(const Traveller& l, const ScoreStack& stack, const Moment& m, float x, float y) {
  float px = m.t * l.x, py = m.t * l.y, dx = l.x, dy = l.y;
  if (l.thin) px = std::round(px), py = std::round(py), dx = std::round(dx), dy = std::round(dy);
  const float sa = ScoreField(l.a, stack).at(x - px, y - py), sb = ScoreField(l.b, stack).at(x - px + dx, y - py + dy);
  return levelOff((1 - m.t) * sa + m.t * sb, m.level);
}

}  // namespace

struct SliceScores::Plan {
  ScoreStack stack;
  std::vector<Gap> gaps;

  Moment momentAt(double position) const {
    const auto& planes = stack.planes;
    Moment m;
    while (m.gap + 2 < planes.size() && planes[m.gap + 1].position <= position) ++m.gap;
    const size_t g = m.gap;
    const float h = float(planes[g + 1].position - planes[g].position);
    const float t = m.t = float((position - planes[g].position) / double(h));
    m.level = kLevel * h, m.limit = kBend * h * t * (1 - t);
    const float rough = std::max(stack.pixel[0], stack.pixel[1]) / h, trust = 1 / (1 + kRough * rough * rough);
    m.cubic[1] = 1 - t, m.cubic[2] = t;
    // Hermite's cubic is the line plus u (slope at a - chord) - v (slope at b - chord); a slope is that of the parabola
    // through three planes, whatever their gaps.
    const auto bend = [&](double gapBeyond, float by, int beyond, int here, int there) {
      const float k = float(gapBeyond), a = by * h / (k + h), q = h / k;
      m.cubic[beyond] -= a * q, m.cubic[here] += a * (q + 1), m.cubic[there] -= a;
    };
    if ((m.before = g > 0)) bend(planes[g].position - planes[g - 1].position, trust * t * (1 - t) * (1 - t), 0, 1, 2);
    if ((m.after = g + 2 < planes.size())) bend(planes[g + 2].position - planes[g + 1].position,
        trust * t * t * (1 - t), 3, 2, 1);
    return m;
  }

  Places placesOf(const Moment& m, float x, float y) const {
    const SliceMotion& motion = gaps[m.gap].motion;
    // The motion is that of where the point is half way.
    SliceMotion::Vector v = motion.at(x, y);
    v = motion.at(x - (m.t - .5f) * v.x, y - (m.t - .5f) * v.y);
    Places p;
    p.x[1] = x - m.t * v.x, p.y[1] = y - m.t * v.y;
    p.x[2] = x + (1 - m.t) * v.x, p.y[2] = y + (1 - m.t) * v.y;
    v = m.before ? gaps[m.gap - 1].motion.at(p.x[1], p.y[1]) : SliceMotion::Vector{0, 0};
    p.x[0] = p.x[1] - v.x, p.y[0] = p.y[1] - v.y;
    v = m.after ? gaps[m.gap + 1].motion.at(p.x[2], p.y[2]) : SliceMotion::Vector{0, 0};
    p.x[3] = p.x[2] + v.x, p.y[3] = p.y[2] + v.y;
    return p;
  }

  void makeGap(size_t g, const std::vector<std::vector<LabelRegions>>& regions);
  void addTravellers(size_t g, GapLabel& label, const std::vector<std::vector<LabelRegions>>& regions);
  float whole(const Gap& gap, const GapLabel& l, const Moment& m, float x, float y) const;
  void fill(const Moment& m, const PixelBox& box, const PixelBox& part, size_t from, Rivals& rivals,
            std::vector<int>& out) const;
  void fillTile(const Moment& m, const PixelBox& box, const PixelBox& part, size_t from, const Rivals& rivals,
                std::vector<int>& out) const;
  void rescue(const Moment& m, const PixelBox& box, std::vector<int>& out) const;
};

void SliceScores::Plan::addTravellers(size_t g, GapLabel& l, const std::vector<std::vector<LabelRegions>>& regions) {
  const ScorePlane &pa = stack.planes[g], &pb = stack.planes[g + 1];
  const LabelScore *a = find(pa, l.label), *b = find(pb, l.label);
  if (!a || !b) return;
  const LabelRegions& ra = regions[g][size_t(a - pa.labels.data())];
  const LabelRegions& rb = regions[g + 1][size_t(b - pb.labels.data())];
  for (const RegionPair& pair : pairRegions(*a, *b, ra, rb, gaps[g].motion, stack, float(pb.position - pa.position))) {
    const Region &p = ra.regions[size_t(pair.a)], &q = rb.regions[size_t(pair.b)];
    Traveller t;
    t.label = l.label, t.x = q.x - p.x, t.y = q.y - p.y;
    t.a = regionScore(*a, ra, pair.a, stack), t.b = regionScore(*b, rb, pair.b, stack);
    t.thin = std::min(p.depth, q.depth) < std::max(stack.pixel[0], stack.pixel[1]);
    t.box = hull(t.a.box, t.b.box).grown(1);
    l.box = hull(l.box, t.box);
    gaps[g].travellers.push_back(std::move(t));
  }
}

void SliceScores::Plan::makeGap(size_t g, const std::vector<std::vector<LabelRegions>>& regions) {
  Gap& gap = gaps[g];
  gap.motion = findMotion(stack, g);
  float most = 0;
  for (size_t i = 0; i < gap.motion.x.size(); ++i)
    most = std::max(most, std::max(std::abs(gap.motion.x[i]), std::abs(gap.motion.y[i])));
  std::vector<int> labels;
  for (size_t k = g; k < g + 2; ++k)
    for (const LabelScore& l : stack.planes[k].labels) labels.push_back(l.label);
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  for (int label : labels) {
    GapLabel l;
    l.label = label;
    for (size_t k = 0; k < 4; ++k) {
      const LabelScore* f = g + k >= 1 && g + k - 1 < stack.planes.size() ?
          find(stack.planes[g + k - 1], label) : nullptr;
      if (!f) continue;
      l.plane[k] = ScoreField(*f, stack);
      if (k == 1 || k == 2)
        l.box = hull(l.box, f->box), l.depth[k - 1] = *std::max_element(f->values.begin(), f->values.end());
    }
    l.box = l.box.grown(1 + int(std::ceil(most)));
    addTravellers(g, l, regions);
    l.box = intersection(l.box, stack.domain);
    gap.labels.push_back(l);
  }
}

/// A label's score, travellers of its own and of others considered.
float SliceScores::Plan::whole(const Gap& gap, const GapLabel& l, const Moment& m, float x, float y) const {
  float v = scoreOf(l, m, placesOf(m, x, y)), own = -m.level, other = -m.level;
  for (const Traveller& t : gap.travellers) {
    if (x < float(t.box.x0) || x >= float(t.box.x1) || y < float(t.box.y0) || y >= float(t.box.y1)) continue;
    float& most = t.label == l.label ? own : other;
    most = std::max(most, scoreOf(t, stack, m, x, y));
  }
  return std::max(std::min(v, -other), own);
}

void SliceScores::Plan::fillTile(const Moment& m, const PixelBox& box, const PixelBox& part,
                                 size_t from, const Rivals& rivals, std::vector<int>& out) const {
  std::vector<const Traveller*> near;
  for (const Traveller& t : gaps[m.gap].travellers)
    if (!intersection(t.box, part).empty()) near.push_back(&t);
  // The motion's nodes are further apart than a tile's corners.
  const float x0 = float(part.x0), y0 = float(part.y0), x1 = float(part.x1 - 1), y1 = float(part.y1 - 1);
  const Places corner[4] = {placesOf(m, x0, y0), placesOf(m, x1, y0), placesOf(m, x0, y1), placesOf(m, x1, y1)};
  const float across = 1 / std::max(1.0f, x1 - x0), down = 1 / std::max(1.0f, y1 - y0), draw = kDraw * m.level;
  for (int y = part.y0; y < part.y1; ++y) {
    const Places left = between(corner[0], corner[2], down * float(y - part.y0));
    const Places right = between(corner[1], corner[3], down * float(y - part.y0));
    for (int x = part.x0; x < part.x1; ++x) {
      float best = -1e30f;
      int& win = out[box.index(x, y)];
      const Places p = between(left, right, across * float(x - part.x0));
      for (size_t k = from; k < rivals.labels.size(); ++k) {
        const GapLabel* l = rivals.labels[k];
        const float v = scoreOf(*l, m, p, best + draw);
        if (v > best + draw) best = v, win = l->label;
      }
      best = -1e-5f * m.level;  // a traveller on its own border is still there
      for (const Traveller* t : near) {
        if (!t->box.contains(x, y)) continue;
        const float v = scoreOf(*t, stack, m, float(x), float(y));
        if (v > best) best = v, win = t->label;
      }
    }
  }
}

void SliceScores::Plan::fill(const Moment& m, const PixelBox& box, const PixelBox& part, size_t from, Rivals& rivals,
                             std::vector<int>& out) const {
  const int w = part.width(), h = part.height(), cx = (part.x0 + part.x1) / 2, cy = (part.y0 + part.y1) / 2;
  const float sx = float(w) * stack.pixel[0], sy = float(h) * stack.pixel[1];
  const size_t mine = rivals.labels.size();
  rivals.narrow(from, part, m, placesOf(m, float(cx), float(cy)), 0.5f * kStretch * std::sqrt(sx * sx + sy * sy));
  bool alone = rivals.labels.size() == mine + 1;
  if (alone)
    for (const Traveller& t : gaps[m.gap].travellers) alone = alone && intersection(t.box, part).empty();
  if (alone) {
    for (int y = part.y0; y < part.y1; ++y)
      std::fill_n(out.begin() + std::ptrdiff_t(box.index(part.x0, y)), w, rivals.labels[mine]->label);
  } else if (size_t(w) * size_t(h) <= kLeaf) {
    fillTile(m, box, part, mine, rivals, out);
  } else {
    PixelBox first = part, second = part;
    if ((sx > sy && w > 1) || h <= 1) first.x1 = second.x0 = cx;
    else first.y1 = second.y0 = cy;
    fill(m, box, first, mine, rivals, out), fill(m, box, second, mine, rivals, out);
  }
  rivals.labels.resize(mine);
}

/// Gives every label of both planes that has won nothing the pixel where it came closest.
void SliceScores::Plan::rescue(const Moment& m, const PixelBox& box, std::vector<int>& out) const {
  const Gap& gap = gaps[m.gap];
  std::vector<int> present;
  for (size_t i = 0; i < out.size(); ++i)
    if (i == 0 || out[i] != out[i - 1]) present.push_back(out[i]);
  std::sort(present.begin(), present.end());
  present.erase(std::unique(present.begin(), present.end()), present.end());
  for (const GapLabel& l : gap.labels) {
    if (!l.plane[1] || !l.plane[2] || std::binary_search(present.begin(), present.end(), l.label)) continue;
    const PixelBox part = intersection(l.box, box);
    float best = -1e30f;
    int bx = -1, by = -1;
    for (int y = part.y0; y < part.y1; ++y)
      for (int x = part.x0; x < part.x1; ++x) {
        const float v = whole(gap, l, m, float(x), float(y));
        if (v > best) best = v, bx = x, by = y;
      }
    if (bx >= 0) out[box.index(bx, by)] = l.label;
  }
}

SliceScores::SliceScores(ScoreStack stack) : plan_(std::make_unique<Plan>()) {
  if (stack.planes.size() < 2)
    throw InputError("at least two planes are needed to interpolate between, got " +
        std::to_string(stack.planes.size()));
  for (size_t k = 1; k < stack.planes.size(); ++k)
    if (!(stack.planes[k].position > stack.planes[k - 1].position))
      throw InputError("planes must lie at increasing positions, got " + std::to_string(stack.planes[k].position) +
          " after " +
                       std::to_string(stack.planes[k - 1].position));
  plan_->stack = std::move(stack);
  const ScoreStack& s = plan_->stack;
  plan_->gaps.resize(s.planes.size() - 1);
  std::vector<std::vector<LabelRegions>> regions(s.planes.size());
  tbb::parallel_for(size_t(0), regions.size(), [&](size_t k) {
    for (const LabelScore& l : s.planes[k].labels) regions[k].push_back(findRegions(l));
  });
  tbb::parallel_for(size_t(0), plan_->gaps.size(), [&](size_t g) { plan_->makeGap(g, regions); });
}

SliceScores::~SliceScores() = default;

const ScoreStack& SliceScores::stack() const { return plan_->stack; }

std::vector<LabelScore> SliceScores::scoresAt(double position) const {
  const Moment m = plan_->momentAt(position);
  const Gap& gap = plan_->gaps[m.gap];
  std::vector<LabelScore> scores;
  for (const GapLabel& l : gap.labels) {
    LabelScore score{l.label, l.box, std::vector<float>(l.box.count())};
    for (int y = l.box.y0; y < l.box.y1; ++y)
      for (int x = l.box.x0; x < l.box.x1; ++x)
        score.values[l.box.index(x, y)] = plan_->whole(gap, l, m, float(x), float(y));
    scores.push_back(std::move(score));
  }
  return scores;
}

LabelScore SliceScores::marginAt(double position, int label) const {
  const Moment m = plan_->momentAt(position);
  const Gap& gap = plan_->gaps[m.gap];
  LabelScore margin;
  margin.label = label;
  for (const GapLabel& own : gap.labels) {
    if (own.label != label) continue;
    margin.box = own.box;
    margin.values.resize(own.box.count());
    for (int y = own.box.y0; y < own.box.y1; ++y)
      for (int x = own.box.x0; x < own.box.x1; ++x) {
        const float mine = plan_->whole(gap, own, m, float(x), float(y));
        float best = gap.labels.size() > 1 ? -1e30f : -mine;
        for (const GapLabel& l : gap.labels)
          if (l.label != label && l.box.contains(x, y)) best = std::max(best,
              plan_->whole(gap, l, m, float(x), float(y)));
        margin.values[own.box.index(x, y)] = best > -1e29f ? 0.5f * (mine - best) : mine;
      }
  }
  return margin;
}

std::vector<int> SliceScores::labelsAt(double position, const PixelBox& box) const {
  const Moment m = plan_->momentAt(position);
  Rivals all;
  for (const GapLabel& l : plan_->gaps[m.gap].labels) all.labels.push_back(&l);
  std::vector<int> out(box.count(), -1);
  if (all.labels.empty() || box.empty()) return out;
  plan_->fill(m, box, box, 0, all, out);
  plan_->rescue(m, box, out);
  return out;
}

}  // namespace slicemorph

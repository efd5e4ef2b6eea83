#include "engine/reconstruct/slice_scores.h"

#include "engine/reconstruct/regions.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <string>

namespace slicemorph {

namespace {

constexpr int kTile = 64;       ///< pixels of a cell that is not cut any further
constexpr int kLeast = 16;      ///< ... not even where its motion bends
constexpr float kBent = 0.25f;  ///< pixels between the middle's motion and that of the corners
constexpr int kBand = 64;       ///< rows that are labelled by one task
constexpr size_t kMoments = 8;  ///< positions of a gap that are labelled together
/// Scores level off at a gap's length: how far away a contour is says nothing about what comes within one
/// gap.
constexpr float kLevel = 0.85f;
/// The cubic may change a slope by this share of a gap per gap: more is a label that jumps, not one that
/// bends.
constexpr float kBend = 0.7f;
/// Slopes over a gap of few pixels are mostly the pixels' rounding: they count 1 / (1 + kRough (pixel /
/// gap)^2).
constexpr float kRough = 0.5f;
/// A label that is not on the next plane lies this many times its depth outside of there.
constexpr float kEnding = 3;
/// A lead of less than this share of the level is a draw: at one gap of two pixels, a 60th of a pixel.
constexpr float kDraw = 0.01f;
/// Pixels of a lead that may come from between a tile's pixels.
constexpr float kSpare = 0.5f;
/// A label less deep than this, pixels, is thin: it is read at every moment, or rounding would take it away.
constexpr float kThin = 1.5f;
/// Room for how much the motion stretches a tile.
constexpr float kStretch = 1.2f;

/// One label in one gap: its fields on the planes before, at, at and after it.
struct GapLabel {
  int label = 0;
  ScoreField plane[4];
  float depth[2] = {0, 0};  ///< greatest score on either plane
  PixelBox box;             ///< holds it throughout
};

/// A region that goes to another place within a gap, where the smooth motion does not take it: it has the way
/// before all that stays.
struct Traveller {
  size_t label = 0;  ///< place in the gap's list
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

float levelOff(float s, float level) {
  const float q = s / level;
  return s / std::sqrt(1 + q * q);
}

/// Up to kMoments positions in one gap, side by side.
struct Moments {
  Moment first;  ///< what they share
  size_t count = 0;
  float apart = 0;  ///< greatest part of a gap from half way
  float t[kMoments] = {}, limit[kMoments] = {}, cubic[4][kMoments] = {};

  void add(const Moment& m) {
    if (!count) first = m;
    t[count] = m.t, limit[count] = m.limit, apart = std::max(apart, std::abs(m.t - .5f));
    for (int k = 0; k < 4; ++k) cubic[k][count] = m.cubic[k];
    ++count;
  }
};

/// What a label's score falls by to a plane where it is not.
float fall(const GapLabel& l, int plane) {
  return kEnding * l.depth[plane == 2 || (plane == 0 && l.plane[1]) || (plane == 3 && !l.plane[2]) ? 0 : 1];
}

/// Fills in the planes where the label is not, and levels off.
void complete(const GapLabel& l, const Moment& m, float* s) {
  if (!l.plane[2]) s[2] = s[1] - fall(l, 2);
  if (!l.plane[1]) s[1] = s[2] - fall(l, 1);
  if (m.before && !l.plane[0]) s[0] = s[1] - fall(l, 0);
  if (m.after && !l.plane[3]) s[3] = s[2] - fall(l, 3);
  for (int k = 0; k < 4; ++k) s[k] = levelOff(s[k], m.level);
}

void read(const GapLabel& l, const Places& p, float* s) {
  for (int k = 0; k < 4; ++k) s[k] = l.plane[k] ? l.plane[k].at(p.x[k], p.y[k]) : 0;
}

float limited(float cubic, float linear, float limit) {
  return std::min(std::max(cubic, linear - limit), linear + limit);
}

float scoreOf(const GapLabel& l, const Moment& m, const Places& p) {
  float s[4];
  read(l, p, s);
  complete(l, m, s);
  const float cubic = m.cubic[0] * s[0] + m.cubic[1] * s[1] + m.cubic[2] * s[2] + m.cubic[3] * s[3];
  return limited(cubic, s[1] + m.t * (s[2] - s[1]), m.limit);
}

/// What a label's score can be, at every moment.
struct Bounds {
  float low[kMoments], high[kMoments];
};

/// ... within `reach` of a point.
Bounds boundsOf(const GapLabel& l, const Moments& m, const Places& p, float reach) {
  float s[4], lo[4], hi[4];
  read(l, p, s);
  for (int k = 0; k < 4; ++k) lo[k] = s[k] - reach, hi[k] = s[k] + reach;
  complete(l, m.first, lo), complete(l, m.first, hi);
  const float spare = 1e-4f * m.first.level;  // rounding must not rule everyone out
  Bounds b;
  for (size_t i = 0; i < kMoments; ++i) {
    float low = 0, high = 0;
    for (int k = 0; k < 4; ++k) {
      const float c = m.cubic[k][i];
      low += c * (c > 0 ? lo[k] : hi[k]), high += c * (c > 0 ? hi[k] : lo[k]);
    }
    b.low[i] = limited(low, lo[1] + m.t[i] * (lo[2] - lo[1]), m.limit[i]) - spare;
    b.high[i] = limited(high, hi[1] + m.t[i] * (hi[2] - hi[1]), m.limit[i]);
  }
  return b;
}

/// The labels that may win in a cell, on top of those of the cells that hold it.
struct Rivals {
  std::vector<int> labels;     ///< places in the gap's list
  std::vector<Bounds> bounds;  ///< of each
  float most[kMoments] = {};   ///< what one of the last cell's has at least

  bool mayWin(size_t k, size_t moment, float draw) const {
    return bounds[k].high[moment] + draw >= most[moment];
  }
  void cut(size_t size) { labels.resize(size), bounds.resize(size); }

  /// Adds those from `from` on that may win within `reach` of a point of `part`.
  void narrow(const std::vector<GapLabel>& all, size_t from, const PixelBox& part, const Moments& m,
              const Places& p, float reach) {
    const size_t end = labels.size();
    std::fill_n(most, kMoments, -1e30f);
    for (int anywhere = 0; anywhere < 2 && labels.size() == end;
         ++anywhere)  // where no label's box is, all compete
      for (size_t k = from; k < end; ++k) {
        const GapLabel& l = all[size_t(labels[k])];
        if (!anywhere && intersection(l.box, part).empty()) continue;
        const Bounds b = boundsOf(l, m, p, reach);
        for (size_t i = 0; i < kMoments; ++i) most[i] = std::max(most[i], b.low[i]);
        labels.push_back(labels[k]), bounds.push_back(b);
      }
    size_t kept = end;
    const float draw = kDraw * m.first.level;
    for (size_t k = end; k < labels.size(); ++k) {
      bool may = false;
      for (size_t i = 0; i < m.count; ++i) may = may || mayWin(k, i, draw);
      if (may) labels[kept] = labels[k], bounds[kept++] = bounds[k];
    }
    cut(kept);
  }
};

float scoreOf(const Traveller& l, const ScoreStack& stack, float t, float level, float x, float y) {
  float px = t * l.x, py = t * l.y, dx = l.x, dy = l.y;
  if (l.thin) px = std::round(px), py = std::round(py), dx = std::round(dx), dy = std::round(dy);
  const float sa = ScoreField(l.a, stack).at(x - px, y - py),
              sb = ScoreField(l.b, stack).at(x - px + dx, y - py + dy);
  return levelOff((1 - t) * sa + t * sb, level);
}

/// Corners of a tile's pixels, carried.
struct Corners {
  float x[4], y[4];

  /// Holds all pixels that are read between the corners.
  PixelBox reach() const {
    return {int(std::floor(*std::min_element(x, x + 4))), int(std::floor(*std::min_element(y, y + 4))),
            int(std::ceil(*std::max_element(x, x + 4))) + 1, int(std::ceil(*std::max_element(y, y + 4))) + 1};
  }
};

/// A label's scores of a tile's points on the four planes, one after the other.
struct TileScores {
  std::vector<float> s;
  bool whole = false;  ///< not only those next to the gap

  void readNear(const GapLabel& l, const Moment& m, const PlanePoints* tile) {
    const size_t n = tile->x.size();
    s.resize(4 * n), whole = false;
    float *a = s.data(), *b = &s[3 * n];  // put off for readFar
    if (l.plane[1]) l.plane[1].read(tile[1], a);
    if (l.plane[2]) l.plane[2].read(tile[2], b);
    if (!l.plane[1]) drop(b, fall(l, 1), a, n);
    if (!l.plane[2]) drop(a, fall(l, 2), b, n);
    level(a, m.level, &s[n], n), level(b, m.level, &s[2 * n], n);
  }

  void readFar(const GapLabel& l, const Moment& m, const PlanePoints* tile) {
    if (whole) return;
    const size_t n = tile->x.size();
    for (int k : {0, 3}) {
      float* to = &s[size_t(k) * n];
      if (!(k ? m.after : m.before))
        std::fill_n(to, n, 0.0f);
      else if (l.plane[k])
        l.plane[k].read(tile[k], to);
      else
        drop(to, fall(l, k), to, n);
      level(to, m.level, to, n);
    }
    whole = true;
  }

 private:
  static void drop(const float* from, float by, float* to, size_t n) {
    for (size_t i = 0; i < n; ++i) to[i] = from[i] - by;
  }
  static void level(const float* from, float at, float* to, size_t n) {
    const float per = 1 / at;
    for (size_t i = 0; i < n; ++i) to[i] = from[i] / std::sqrt(1 + (from[i] * per) * (from[i] * per));
  }
};

/// A cell whose pixels are looked at one by one.
struct Tile {
  PixelBox part, half;        ///< its pixels, and those that they come from half way
  Corners corners[kMoments];  ///< of its pixels half way, at every moment
  PlanePoints onPlane[4];     ///< the pixels of `half`
  std::vector<TileScores> scores;
  PlanePoints points;  ///< its pixels at one moment
  std::vector<float> most, blend;
  float best[kTile];
  int winner[kTile];  ///< place in the gap's list

  /// The greatest score on the way from plane to plane, of all rivals from `from` on.
  void findMost(const Moments& m, size_t i, const Rivals& rivals, size_t from) {
    const size_t count = half.count();
    const float t = m.t[i];
    most.assign(count, -1e30f);
    for (size_t r = from; r < rivals.labels.size(); ++r) {
      if (!rivals.mayWin(r, i, kDraw * m.first.level)) continue;
      const float *a = &scores[r - from].s[count], *b = a + count;
      for (size_t k = 0; k < count; ++k) most[k] = std::max(most[k], a[k] + t * (b[k] - a[k]));
    }
  }

  /// Whether a score comes within `spare` of the greatest anywhere.
  bool comesNear(const TileScores& score, float t, float spare) const {
    const size_t count = half.count();
    const float *a = &score.s[count], *b = a + count;
    int near = 0;
    for (size_t k = 0; k < count; ++k) near |= a[k] + t * (b[k] - a[k]) + spare > most[k];
    return near;
  }

  /// A score at one moment, of the pixels half way.
  void blendScore(const TileScores& score, const Moments& m, size_t i) {
    const size_t count = half.count();
    const float *s0 = score.s.data(), *s1 = s0 + count, *s2 = s1 + count, *s3 = s2 + count;
    const float c0 = m.cubic[0][i], c1 = m.cubic[1][i], c2 = m.cubic[2][i], c3 = m.cubic[3][i];
    const float t = m.t[i], limit = m.limit[i];
    for (size_t k = 0; k < count; ++k)
      blend[k] =
          limited(c0 * s0[k] + c1 * s1[k] + c2 * s2[k] + c3 * s3[k], s1[k] + t * (s2[k] - s1[k]), limit);
  }

  /// Gives a label the pixels where its blended score beats the best one.
  void compete(int label, const int* at, float draw) {
    const float *fx = points.fx.data(), *fy = points.fy.data();
    for (size_t k = 0, row = size_t(half.width()); k < part.count(); ++k) {
      const float *p = &blend[size_t(at[k])], *q = p + row;
      const float low = p[0] + fx[k] * (p[1] - p[0]), high = q[0] + fx[k] * (q[1] - q[0]);
      const float v = low + fy[k] * (high - low);
      const bool wins = v > best[k] + draw;
      best[k] = wins ? v : best[k], winner[k] = wins ? label : winner[k];
    }
  }
};

/// What a task on a gap's slices writes: labels of every slice's pixels, and which of the gap's labels won
/// any.
struct GapSlices {
  int* labels = nullptr;
  std::vector<char> seen;
  Tile tile;  ///< every tile's in its turn
};

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
    const float rough = std::max(stack.pixel[0], stack.pixel[1]) / h,
                trust = 1 / (1 + kRough * rough * rough);
    m.cubic[1] = 1 - t, m.cubic[2] = t;
    // Hermite's cubic is the line plus u (slope at a - chord) - v (slope at b - chord); a slope is that of
    // the parabola through three planes, whatever their gaps.
    const auto bend = [&](double gapBeyond, float by, int beyond, int here, int there) {
      const float k = float(gapBeyond), a = by * h / (k + h), q = h / k;
      m.cubic[beyond] -= a * q, m.cubic[here] += a * (q + 1), m.cubic[there] -= a;
    };
    if ((m.before = g > 0))
      bend(planes[g].position - planes[g - 1].position, trust * t * (1 - t) * (1 - t), 0, 1, 2);
    if ((m.after = g + 2 < planes.size()))
      bend(planes[g + 2].position - planes[g + 1].position, trust * t * t * (1 - t), 3, 2, 1);
    return m;
  }

  /// Where what is at a point half way came from: the motion that carries it.
  SliceMotion::Vector motionAt(const Moment& m, float t, float x, float y) const {
    const SliceMotion& motion = gaps[m.gap].motion;
    const SliceMotion::Vector v = motion.at(x, y);
    return motion.at(x - (t - .5f) * v.x, y - (t - .5f) * v.y);
  }

  /// Where a tile's pixels are half way.
  Corners halfWay(const Moment& m, float t, const PixelBox& tile) const {
    Corners c;
    for (int k = 0; k < 4; ++k) {
      const float x = float(k & 1 ? tile.x1 - 1 : tile.x0), y = float(k & 2 ? tile.y1 - 1 : tile.y0);
      const SliceMotion::Vector v = motionAt(m, t, x, y);
      c.x[k] = x + (.5f - t) * v.x, c.y[k] = y + (.5f - t) * v.y;
    }
    return c;
  }

  /// Whether the motion of a cell's pixels is known by that of its corners.
  bool movesEvenly(const Moments& m, const PixelBox& part) const {
    const SliceMotion& motion = gaps[m.first.gap].motion;
    const float x0 = float(part.x0), y0 = float(part.y0), x1 = float(part.x1 - 1), y1 = float(part.y1 - 1);
    const SliceMotion::Vector a = motion.at(x0, y0), b = motion.at(x1, y0), c = motion.at(x0, y1),
                              d = motion.at(x1, y1);
    const SliceMotion::Vector middle = motion.at(.5f * (x0 + x1), .5f * (y0 + y1));
    const float x = middle.x - .25f * (a.x + b.x + c.x + d.x), y = middle.y - .25f * (a.y + b.y + c.y + d.y);
    return std::max(std::abs(x), std::abs(y)) <= kBent;
  }

  /// Places of what is at (x, y) half way.
  Places placesOf(const Moment& m, float x, float y) const {
    return placesOf(m, x, y, gaps[m.gap].motion.at(x, y));
  }

  /// ... and moves by `v` from plane to plane.
  Places placesOf(const Moment& m, float x, float y, SliceMotion::Vector v) const {
    Places p;
    p.x[1] = x - .5f * v.x, p.y[1] = y - .5f * v.y;
    p.x[2] = x + .5f * v.x, p.y[2] = y + .5f * v.y;
    v = m.before ? gaps[m.gap - 1].motion.at(p.x[1], p.y[1]) : SliceMotion::Vector{0, 0};
    p.x[0] = p.x[1] - v.x, p.y[0] = p.y[1] - v.y;
    v = m.after ? gaps[m.gap + 1].motion.at(p.x[2], p.y[2]) : SliceMotion::Vector{0, 0};
    p.x[3] = p.x[2] + v.x, p.y[3] = p.y[2] + v.y;
    return p;
  }

  void makeGap(size_t g, const std::vector<std::vector<LabelRegions>>& regions);
  void addTravellers(size_t g, GapLabel& label, const std::vector<std::vector<LabelRegions>>& regions);
  float whole(const Gap& gap, const GapLabel& l, const Moment& m, float x, float y) const;
  void fill(const Moments& m, const PixelBox& part, size_t from, Rivals& rivals, GapSlices& out) const;
  void fillTile(const Moments& m, const PixelBox& part, size_t from, const Rivals& rivals,
                GapSlices& out) const;
  void placeTile(const Moments& m, size_t begin, size_t end, const PixelBox& part, Tile& tile) const;
  void findWinners(const Moments& m, size_t i, size_t from, const Rivals& rivals, Tile& tile) const;
  void rescue(const Moment& m, int label, int* slice) const;
};

void SliceScores::Plan::addTravellers(size_t g, GapLabel& l,
                                      const std::vector<std::vector<LabelRegions>>& regions) {
  const ScorePlane &pa = stack.planes[g], &pb = stack.planes[g + 1];
  const LabelScore *a = find(pa, l.label), *b = find(pb, l.label);
  if (!a || !b) return;
  const LabelRegions& ra = regions[g][size_t(a - pa.labels.data())];
  const LabelRegions& rb = regions[g + 1][size_t(b - pb.labels.data())];
  for (const RegionPair& pair :
       pairRegions(ra, rb, gaps[g].motion, stack, float(pb.position - pa.position))) {
    const Region &p = ra.regions[size_t(pair.a)], &q = rb.regions[size_t(pair.b)];
    Traveller t;
    t.label = gaps[g].labels.size(), t.x = q.x - p.x, t.y = q.y - p.y;
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
      const LabelScore* f =
          g + k >= 1 && g + k - 1 < stack.planes.size() ? find(stack.planes[g + k - 1], label) : nullptr;
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
  const SliceMotion::Vector back = motionAt(m, m.t, x, y);
  const float half = m.t - .5f;
  float v = scoreOf(l, m, placesOf(m, x - half * back.x, y - half * back.y, back)), own = -m.level,
        other = -m.level;
  for (const Traveller& t : gap.travellers) {
    if (x < float(t.box.x0) || x >= float(t.box.x1) || y < float(t.box.y0) || y >= float(t.box.y1)) continue;
    float& most = gap.labels[t.label].label == l.label ? own : other;
    most = std::max(most, scoreOf(t, stack, m.t, m.level, x, y));
  }
  return std::max(std::min(v, -other), own);
}

/// Places of the tile's pixels at moments from `begin` up to `end`; of one alone, its own.
void SliceScores::Plan::placeTile(const Moments& m, size_t begin, size_t end, const PixelBox& part,
                                  Tile& tile) const {
  tile.part = part;
  PixelBox& half = tile.half = {};
  for (size_t i = begin; i < end; ++i) {
    tile.corners[i] = halfWay(m.first, m.t[i], part);
    half = hull(half, tile.corners[i].reach());
  }
  Corners from{{float(half.x0), float(half.x1 - 1), float(half.x0), float(half.x1 - 1)},
               {float(half.y0), float(half.y0), float(half.y1 - 1), float(half.y1 - 1)}};
  if (end - begin == 1) {
    half = part, from = tile.corners[begin];
    tile.corners[begin] = halfWay(m.first, .5f, part);
  }
  tile.blend.assign(half.count() + size_t(half.width()) + 1, 0);  // the last pixels' neighbours weigh nothing
  Corners corners[4];
  for (int c = 0; c < 4; ++c) {
    const Places p = placesOf(m.first, from.x[c], from.y[c]);
    for (int k = 0; k < 4; ++k) corners[k].x[c] = p.x[k], corners[k].y[c] = p.y[k];
  }
  for (int k = 0; k < 4; ++k) tile.onPlane[k].spread(corners[k].x, corners[k].y, half.width(), half.height());
}

void SliceScores::Plan::findWinners(const Moments& m, size_t i, size_t from, const Rivals& rivals,
                                    Tile& tile) const {
  const std::vector<GapLabel>& labels = gaps[m.first.gap].labels;
  const float draw = kDraw * m.first.level;
  const float spare = 2 * m.limit[i] + draw + kSpare * std::min(stack.pixel[0], stack.pixel[1]);
  tile.points.spread(tile.corners[i].x, tile.corners[i].y, tile.part.width(), tile.part.height());
  int at[kTile];
  for (size_t k = 0; k < tile.part.count(); ++k)
    at[k] = int(tile.half.index(tile.points.x[k], tile.points.y[k]));
  std::fill_n(tile.best, kTile, -1e30f);
  tile.findMost(m, i, rivals, from);
  for (size_t r = from; r < rivals.labels.size(); ++r) {
    TileScores& score = tile.scores[r - from];
    if (!rivals.mayWin(r, i, draw) || !tile.comesNear(score, m.t[i], spare)) continue;
    score.readFar(labels[size_t(rivals.labels[r])], m.first, tile.onPlane);
    tile.blendScore(score, m, i);
    tile.compete(rivals.labels[r], at, draw);
  }
}

void SliceScores::Plan::fillTile(const Moments& m, const PixelBox& part, size_t from, const Rivals& rivals,
                                 GapSlices& out) const {
  const Gap& gap = gaps[m.first.gap];
  std::vector<const Traveller*> near;
  for (const Traveller& t : gap.travellers)
    if (!intersection(t.box, part).empty()) near.push_back(&t);
  Tile& tile = out.tile;
  bool thin = false;
  for (size_t r = from; r < rivals.labels.size(); ++r) {
    const GapLabel& l = gap.labels[size_t(rivals.labels[r])];
    thin = thin || std::max(l.depth[0], l.depth[1]) < kThin * std::max(stack.pixel[0], stack.pixel[1]);
  }
  tile.scores.resize(std::max(tile.scores.size(), rivals.labels.size() - from));
  for (size_t i = 0; i < m.count; ++i) {
    if (thin || i == 0) {
      placeTile(m, i, thin ? i + 1 : m.count, part, tile);
      for (size_t r = from; r < rivals.labels.size(); ++r)
        tile.scores[r - from].readNear(gap.labels[size_t(rivals.labels[r])], m.first, tile.onPlane);
    }
    findWinners(m, i, from, rivals, tile);
    int* slice = out.labels + i * stack.domain.count();
    for (int y = part.y0; y < part.y1; ++y)
      for (int x = part.x0; x < part.x1; ++x) {
        size_t label = size_t(tile.winner[part.index(x, y)]);
        float best = -1e-5f * m.first.level;  // a traveller on its own border is still there
        for (const Traveller* t : near) {
          if (!t->box.contains(x, y)) continue;
          const float v = scoreOf(*t, stack, m.t[i], m.first.level, float(x), float(y));
          if (v > best) best = v, label = t->label;
        }
        slice[stack.domain.index(x, y)] = gap.labels[label].label;
        out.seen[i * gap.labels.size() + label] = 1;
      }
  }
}

void SliceScores::Plan::fill(const Moments& m, const PixelBox& part, size_t from, Rivals& rivals,
                             GapSlices& out) const {
  const Gap& gap = gaps[m.first.gap];
  const int w = part.width(), h = part.height(), cx = (part.x0 + part.x1) / 2, cy = (part.y0 + part.y1) / 2;
  const float sx = float(w) * stack.pixel[0], sy = float(h) * stack.pixel[1];
  const size_t mine = rivals.labels.size();
  const SliceMotion::Vector v = gap.motion.at(float(cx), float(cy));
  const float reach =
      .5f * kStretch * std::hypot(sx, sy) + m.apart * std::hypot(v.x * stack.pixel[0], v.y * stack.pixel[1]);
  rivals.narrow(gap.labels, from, part, m, placesOf(m.first, float(cx), float(cy)), reach);
  bool alone = rivals.labels.size() == mine + 1;
  if (alone)
    for (const Traveller& t : gap.travellers) alone = alone && intersection(t.box, part).empty();
  if (alone) {
    const int label = rivals.labels[mine];
    for (size_t i = 0; i < m.count; ++i) {
      out.seen[i * gap.labels.size() + size_t(label)] = 1;
      for (int y = part.y0; y < part.y1; ++y)
        std::fill_n(out.labels + i * stack.domain.count() + stack.domain.index(part.x0, y), w,
                    gap.labels[size_t(label)].label);
    }
  } else if (w * h <= kLeast || (w * h <= kTile && movesEvenly(m, part))) {
    fillTile(m, part, mine, rivals, out);
  } else {
    PixelBox first = part, second = part;
    if ((sx > sy && w > 1) || h <= 1)
      first.x1 = second.x0 = cx;
    else
      first.y1 = second.y0 = cy;
    fill(m, first, mine, rivals, out), fill(m, second, mine, rivals, out);
  }
  rivals.cut(mine);
}

/// Gives a label that has won nothing the pixel where it came closest.
void SliceScores::Plan::rescue(const Moment& m, int label, int* slice) const {
  const Gap& gap = gaps[m.gap];
  const GapLabel& l = gap.labels[size_t(label)];
  float best = -1e30f;
  size_t at = 0;
  for (int y = l.box.y0; y < l.box.y1; ++y)
    for (int x = l.box.x0; x < l.box.x1; ++x) {
      const float v = whole(gap, l, m, float(x), float(y));
      if (v > best) best = v, at = stack.domain.index(x, y);
    }
  slice[at] = l.label;
}

SliceScores::SliceScores(ScoreStack stack) : plan_(std::make_unique<Plan>()) {
  if (stack.planes.size() < 2)
    throw InputError("at least two planes are needed to interpolate between, got " +
                     std::to_string(stack.planes.size()));
  for (size_t k = 1; k < stack.planes.size(); ++k)
    if (!(stack.planes[k].position > stack.planes[k - 1].position))
      throw InputError("planes must lie at increasing positions, got " +
                       std::to_string(stack.planes[k].position) + " after " +
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
          if (l.label != label && l.box.contains(x, y))
            best = std::max(best, plan_->whole(gap, l, m, float(x), float(y)));
        margin.values[own.box.index(x, y)] = best > -1e29f ? 0.5f * (mine - best) : mine;
      }
  }
  return margin;
}

std::vector<int> SliceScores::labelsBetween(const std::vector<double>& positions) const {
  const PixelBox& domain = plan_->stack.domain;
  std::vector<int> out(positions.size() * domain.count());
  for (size_t begin = 0; begin < positions.size(); begin += kMoments) {
    Moments m;
    for (size_t i = begin; i < std::min(begin + kMoments, positions.size()); ++i)
      m.add(plan_->momentAt(positions[i]));
    const std::vector<GapLabel>& labels = plan_->gaps[m.first.gap].labels;
    std::vector<GapSlices> bands(size_t((domain.height() + kBand - 1) / kBand));
    tbb::parallel_for(size_t(0), bands.size(), [&](size_t b) {
      Rivals all;
      for (size_t k = 0; k < labels.size(); ++k) all.labels.push_back(int(k));
      all.bounds.resize(labels.size());
      bands[b].labels = &out[begin * domain.count()], bands[b].seen.assign(m.count * labels.size(), 0);
      PixelBox part = domain;
      part.y0 += int(b) * kBand, part.y1 = std::min(part.y0 + kBand, domain.y1);
      plan_->fill(m, part, 0, all, bands[b]);
    });
    for (size_t i = 0; i < m.count; ++i)
      for (size_t k = 0; k < labels.size(); ++k) {
        bool seen = !labels[k].plane[1] || !labels[k].plane[2];
        for (const GapSlices& band : bands) seen = seen || band.seen[i * labels.size() + k];
        if (!seen)
          plan_->rescue(plan_->momentAt(positions[begin + i]), int(k), &out[(begin + i) * domain.count()]);
      }
  }
  return out;
}

}  // namespace slicemorph

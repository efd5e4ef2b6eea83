#include "engine/reconstruct/labels_in_gap.h"

#include "engine/reconstruct/slice_tile.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace slicemorph {

namespace {

/// pixels of a cell that is not divided further, even if its motion is not linear
constexpr int kLeastTile = 16;
/// largest difference, in pixels, of the motion in the middle from the mean of the corners'
constexpr float kBent = 0.25f;
constexpr int kBandRows = 64;  ///< rows labelled by one task
/// Allowance, in pixels, for scores that peak between a tile's pixels.
constexpr float kSpare = 0.5f;
/// A label less deep than this, in pixels, is thin: it is evaluated separately at every moment, because
/// interpolating between pixels could remove it.
constexpr float kThin = 1.5f;
/// Allowance for the motion's stretching of a tile.
constexpr float kTileStretch = 1.2f;

/// Output of one task: the labels of every slice's pixels, and which of the gap's labels won a pixel.
struct GapSlices {
  int* labels = nullptr;
  std::vector<char> seen;
  SliceTile tile;  ///< reused for every tile
};

TileCorners cornersOf(const PixelBox& tile) {
  const float x0 = float(tile.x0), y0 = float(tile.y0), x1 = float(tile.x1 - 1), y1 = float(tile.y1 - 1);
  return {{x0, x1, x0, x1}, {y0, y0, y1, y1}};
}

/// Positions, half way, of what is in a tile's corner pixels at moment i.
TileCorners halfWay(const SlicePlan& plan, const Moments& m, size_t i, const PixelBox& tile) {
  TileCorners c = cornersOf(tile);
  for (int k = 0; k < 4; ++k) {
    const float t = m.t[i];
    const SliceMotion::Vector v = motionAt(plan, m.first, t, c.x[k], c.y[k]);
    c.x[k] += (.5f - t) * v.x, c.y[k] += (.5f - t) * v.y;
    const SliceMotion::Vector bend = bendOf(positionsOf(plan, m.first, c.x[k], c.y[k], v), m.path[i]);
    c.x[k] -= bend.x, c.y[k] -= bend.y;
  }
  return c;
}

/// How far, in world units, the path of what is at these positions comes from where it is half way.
float strayOf(const PlanePositions& p, const Moments& m, const float* pixel) {
  float most = 0;
  for (size_t i = 0; i < m.count; ++i) {
    const SliceMotion::Vector bend = bendOf(p, m.path[i]);
    const float by = m.t[i] - .5f;
    most = std::max(most, std::hypot((by * (p.x[2] - p.x[1]) + bend.x) * pixel[0],
                                     (by * (p.y[2] - p.y[1]) + bend.y) * pixel[1]));
  }
  return most;
}

/// Whether the motion within a cell is nearly the bilinear interpolation of that at its corners.
bool movesEvenly(const SlicePlan& plan, const Moments& m, const PixelBox& part) {
  const SliceMotion& motion = plan.gaps[m.first.gap].motion;
  const float x0 = float(part.x0), y0 = float(part.y0), x1 = float(part.x1 - 1), y1 = float(part.y1 - 1);
  const SliceMotion::Vector a = motion.at(x0, y0), b = motion.at(x1, y0), c = motion.at(x0, y1),
                            d = motion.at(x1, y1);
  const SliceMotion::Vector middle = motion.at(.5f * (x0 + x1), .5f * (y0 + y1));
  const float x = middle.x - .25f * (a.x + b.x + c.x + d.x), y = middle.y - .25f * (a.y + b.y + c.y + d.y);
  return std::max(std::abs(x), std::abs(y)) <= kBent;
}

/// Sets the positions of the tile's pixels for moments `begin` to `end`. For a single moment `half` holds the
/// tile's own pixels.
void placeTile(const SlicePlan& plan, const Moments& m, size_t begin, size_t end, const PixelBox& part,
               SliceTile& tile) {
  tile.part = part;
  PixelBox& half = tile.half = {};
  for (size_t i = begin; i < end; ++i) {
    tile.corners[i] = halfWay(plan, m, i, part);
    half = hull(half, tile.corners[i].reach());
  }
  TileCorners from = cornersOf(half);
  if (end - begin == 1) {
    half = part, from = tile.corners[begin];
    tile.corners[begin] = cornersOf(part);
  }
  // the neighbours after the last pixel have weight 0
  tile.blend.assign(half.count() + size_t(half.width()) + 1, 0);
  TileCorners corners[4];
  for (int c = 0; c < 4; ++c) {
    const PlanePositions p = positionsOf(plan, m.first, from.x[c], from.y[c]);
    for (int k = 0; k < 4; ++k) corners[k].x[c] = p.x[k], corners[k].y[c] = p.y[k];
  }
  for (int k = 0; k < 4; ++k) tile.onPlane[k].spread(corners[k].x, corners[k].y, half.width(), half.height());
}

void findWinners(const SlicePlan& plan, const Moments& m, size_t i, size_t from, const Rivals& rivals,
                 SliceTile& tile) {
  const std::vector<GapLabel>& labels = plan.gaps[m.first.gap].labels;
  const float draw = m.first.draw;
  const float spare = 2 * m.limit[i] + draw + kSpare * std::min(plan.stack.pixel[0], plan.stack.pixel[1]);
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

void fillTile(const SlicePlan& plan, const Moments& m, const PixelBox& part, size_t from,
              const Rivals& rivals, GapSlices& out) {
  const Gap& gap = plan.gaps[m.first.gap];
  std::vector<const Traveller*> near;
  for (const Traveller& t : gap.travellers)
    if (!intersection(t.box, part).empty()) near.push_back(&t);
  SliceTile& tile = out.tile;
  bool thin = false;
  for (size_t r = from; r < rivals.labels.size(); ++r) {
    const GapLabel& l = gap.labels[size_t(rivals.labels[r])];
    thin =
        thin || std::max(l.depth[0], l.depth[1]) < kThin * std::max(plan.stack.pixel[0], plan.stack.pixel[1]);
  }
  tile.scores.resize(std::max(tile.scores.size(), rivals.labels.size() - from));
  for (size_t i = 0; i < m.count; ++i) {
    if (thin || i == 0) {
      placeTile(plan, m, i, thin ? i + 1 : m.count, part, tile);
      for (size_t r = from; r < rivals.labels.size(); ++r)
        tile.scores[r - from].readNear(gap.labels[size_t(rivals.labels[r])], m.first, tile.onPlane);
    }
    findWinners(plan, m, i, from, rivals, tile);
    int* slice = out.labels + i * plan.stack.domain.count();
    for (int y = part.y0; y < part.y1; ++y)
      for (int x = part.x0; x < part.x1; ++x) {
        size_t label = size_t(tile.winner[part.index(x, y)]);
        float best = -1e-5f * m.first.level;  // a traveller counts on its own border, too
        for (const Traveller* t : near) {
          if (!t->box.contains(x, y)) continue;
          const float v = scoreOf(*t, plan.stack, m.t[i], m.first.level, float(x), float(y));
          if (v > best) best = v, label = t->label;
        }
        slice[plan.stack.domain.index(x, y)] = gap.labels[label].label;
        out.seen[i * gap.labels.size() + label] = 1;
      }
  }
}

void fillCell(const SlicePlan& plan, const Moments& m, const PixelBox& part, size_t from, Rivals& rivals,
              GapSlices& out) {
  const Gap& gap = plan.gaps[m.first.gap];
  const int w = part.width(), h = part.height(), cx = (part.x0 + part.x1) / 2, cy = (part.y0 + part.y1) / 2;
  const float sx = float(w) * plan.stack.pixel[0], sy = float(h) * plan.stack.pixel[1];
  const size_t mine = rivals.labels.size();
  const PlanePositions middle = positionsOf(plan, m.first, float(cx), float(cy));
  const float reach = .5f * kTileStretch * std::hypot(sx, sy) + strayOf(middle, m, plan.stack.pixel);
  rivals.narrow(gap.labels, from, part, m, middle, reach);
  bool alone = rivals.labels.size() == mine + 1;
  if (alone)
    for (const Traveller& t : gap.travellers) alone = alone && intersection(t.box, part).empty();
  if (alone) {
    const int label = rivals.labels[mine];
    for (size_t i = 0; i < m.count; ++i) {
      out.seen[i * gap.labels.size() + size_t(label)] = 1;
      for (int y = part.y0; y < part.y1; ++y)
        std::fill_n(out.labels + i * plan.stack.domain.count() + plan.stack.domain.index(part.x0, y), w,
                    gap.labels[size_t(label)].label);
    }
  } else if (w * h <= kLeastTile || (w * h <= kTile && movesEvenly(plan, m, part))) {
    fillTile(plan, m, part, mine, rivals, out);
  } else {
    PixelBox first = part, second = part;
    if ((sx > sy && w > 1) || h <= 1)
      first.x1 = second.x0 = cx;
    else
      first.y1 = second.y0 = cy;
    fillCell(plan, m, first, mine, rivals, out), fillCell(plan, m, second, mine, rivals, out);
  }
  rivals.cut(mine);
}

/// Gives a label that won nothing the pixel where it came closest.
void rescue(const SlicePlan& plan, const Moment& m, int label, int* slice) {
  const Gap& gap = plan.gaps[m.gap];
  const GapLabel& l = gap.labels[size_t(label)];
  float best = -1e30f;
  size_t at = 0;
  for (int y = l.box.y0; y < l.box.y1; ++y)
    for (int x = l.box.x0; x < l.box.x1; ++x) {
      const float v = wholeScore(plan, l, m, float(x), float(y));
      if (v > best) best = v, at = plan.stack.domain.index(x, y);
    }
  slice[at] = l.label;
}

}  // namespace

std::vector<int> labelsInGap(const SlicePlan& plan, const std::vector<double>& positions) {
  const PixelBox& domain = plan.stack.domain;
  std::vector<int> out(positions.size() * domain.count());
  for (size_t begin = 0; begin < positions.size(); begin += kMoments) {
    Moments m;
    for (size_t i = begin; i < std::min(begin + kMoments, positions.size()); ++i)
      m.add(momentAt(plan.stack, positions[i]));
    const std::vector<GapLabel>& labels = plan.gaps[m.first.gap].labels;
    std::vector<GapSlices> bands(size_t((domain.height() + kBandRows - 1) / kBandRows));
    tbb::parallel_for(size_t(0), bands.size(), [&](size_t b) {
      Rivals all;
      for (size_t k = 0; k < labels.size(); ++k) all.labels.push_back(int(k));
      all.bounds.resize(labels.size());
      bands[b].labels = &out[begin * domain.count()], bands[b].seen.assign(m.count * labels.size(), 0);
      PixelBox part = domain;
      part.y0 += int(b) * kBandRows, part.y1 = std::min(part.y0 + kBandRows, domain.y1);
      fillCell(plan, m, part, 0, all, bands[b]);
    });
    for (size_t i = 0; i < m.count; ++i)
      for (size_t k = 0; k < labels.size(); ++k) {
        bool seen = !labels[k].plane[1] || !labels[k].plane[2];
        for (const GapSlices& band : bands) seen = seen || band.seen[i * labels.size() + k];
        if (!seen)
          rescue(plan, momentAt(plan.stack, positions[begin + i]), int(k),
                 &out[(begin + i) * domain.count()]);
      }
  }
  return out;
}

}  // namespace slicemorph

#include "engine/reconstruct/regions.h"

#include "engine/reconstruct/mask_distance.h"

#include <cmath>

namespace slicemorph {

namespace {

/// How far a region may go sideways per unit along the stack before another beginning is likelier: two gaps (63
/// degrees).
constexpr float kSteepest = 2;

float radiusOf(const Region& r, const ScoreStack& stack) {
  return std::sqrt(float(r.count) * stack.pixel[0] * stack.pixel[1] / 3.14159265f);
}

/// Marks the regions of `a` and `b` that meet when a's pixels are carried `way` times the motion; stops once all do.
void markMeeting(const LabelScore& a, const LabelScore& b, const LabelRegions& ra, const LabelRegions& rb,
                 const SliceMotion& motion, float way, std::vector<char>& meetsA, std::vector<char>& meetsB) {
  const auto missing = [](const std::vector<char>& meets) { return size_t(std::count(meets.begin(), meets.end(), 0)); };
  size_t left = missing(meetsA) + missing(meetsB);
  for (int y = a.box.y0; y < a.box.y1 && left; ++y)
    for (int x = a.box.x0; x < a.box.x1 && left; ++x) {
      const int i = ra.map[a.box.index(x, y)];
      if (i < 0) continue;
      const SliceMotion::Vector v = motion.at(float(x), float(y));
      const int bx = int(std::floor(float(x) + way * v.x + .5f)), by = int(std::floor(float(y) + way * v.y + .5f));
      const int j = b.box.contains(bx, by) ? rb.map[b.box.index(bx, by)] : -1;
      if (j < 0 || (meetsA[size_t(i)] && meetsB[size_t(j)])) continue;
      left -= size_t(!meetsA[size_t(i)]) + size_t(!meetsB[size_t(j)]);
      meetsA[size_t(i)] = meetsB[size_t(j)] = 1;
    }
}

struct Candidate {
  float cost;
  int a, b;
  bool trusted;
};

}  // namespace

LabelRegions findRegions(const LabelScore& score) {
  const PixelBox& box = score.box;
  LabelRegions result;
  result.map.assign(box.count(), -1);
  std::vector<std::pair<int, int>> front;
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      if (score.values[box.index(x, y)] <= 0 || result.map[box.index(x, y)] >= 0) continue;
      const int id = int(result.regions.size());
      Region r;
      double sx = 0, sy = 0;
      front.assign(1, {x, y}), result.map[box.index(x, y)] = id;
      while (!front.empty()) {
        const auto [px, py] = front.back();
        front.pop_back();
        r.box.add(px, py), ++r.count, sx += px, sy += py;
        r.depth = std::max(r.depth, score.values[box.index(px, py)]);
        for (int qy = std::max(py - 1, box.y0); qy < std::min(py + 2, box.y1); ++qy)
          for (int qx = std::max(px - 1, box.x0); qx < std::min(px + 2, box.x1); ++qx) {
            const size_t q = box.index(qx, qy);
            if (score.values[q] > 0 && result.map[q] < 0) result.map[q] = id, front.emplace_back(qx, qy);
          }
      }
      r.x = float(sx / double(r.count)), r.y = float(sy / double(r.count));
      result.regions.push_back(r);
    }
  return result;
}

std::vector<RegionPair> pairRegions(const LabelScore& a, const LabelScore& b, const LabelRegions& ra,
    const LabelRegions& rb,
                                    const SliceMotion& motion, const ScoreStack& stack, float gap) {
  std::vector<char> tiedA(ra.regions.size(), 0), tiedB(rb.regions.size(), 0);
  markMeeting(a, b, ra, rb, motion, 1, tiedA, tiedB), markMeeting(b, a, rb, ra, motion, -1, tiedB, tiedA);
  bool any = std::count(tiedA.begin(), tiedA.end(), 1) > 0;
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < tiedA.size(); ++i)
    for (size_t j = 0; j < tiedB.size(); ++j) {
      if (tiedA[i] || tiedB[j]) continue;
      const Region &p = ra.regions[i], &q = rb.regions[j];
      const float d = std::hypot((p.x - q.x) * stack.pixel[0], (p.y - q.y) * stack.pixel[1]);
      const float rp = radiusOf(p, stack), rq = radiusOf(q, stack);
      candidates.push_back({d + std::abs(rp - rq), int(i), int(j), d <= kSteepest * gap + rp + rq});
    }
  std::stable_sort(candidates.begin(), candidates.end(),
      [](const Candidate& p, const Candidate& q) { return p.cost < q.cost; });
  std::vector<RegionPair> pairs;
  for (const Candidate& c : candidates) {
    if (tiedA[size_t(c.a)] || tiedB[size_t(c.b)] || (!c.trusted && any)) continue;
    pairs.push_back({c.a, c.b}), tiedA[size_t(c.a)] = tiedB[size_t(c.b)] = 1, any = true;
  }
  return pairs;
}

LabelScore regionScore(const LabelScore& score, const LabelRegions& regions, int region, const ScoreStack& stack) {
  LabelScore own;
  own.label = score.label;
  own.box = intersection(regions.regions[size_t(region)].box.grown(1), score.box);
  std::vector<std::uint8_t> mask(own.box.count());
  for (int y = own.box.y0; y < own.box.y1; ++y)
    for (int x = own.box.x0; x < own.box.x1; ++x)
      mask[own.box.index(x, y)] = regions.map[score.box.index(x, y)] == region;
  own.values = maskDistance(mask, own.box, stack.pixel[0], stack.pixel[1], regions.regions[size_t(region)].depth);
  for (int y = own.box.y0; y < own.box.y1; ++y)
    for (int x = own.box.x0; x < own.box.x1; ++x) {
      float& v = own.values[own.box.index(x, y)];
      const float all = score.values[score.box.index(x, y)];
      v = v > 0 ? all : std::min(v, all);
    }
  return own;
}

}  // namespace slicemorph

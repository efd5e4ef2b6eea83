#include "engine/reconstruct/regions.h"

#include "engine/numerics/mask_distance.h"
#include "engine/reconstruct/slice_pieces.h"

#include <cmath>

namespace slicemorph {

namespace {

/// How far a region may move sideways per unit along the stack before it is more likely that one region ends
/// and another begins: two gaps (63 degrees). Chosen by hand.
constexpr float kSteepestShift = 2;

float radiusOf(const LabelRegion& r, const ScoreStack& stack) {
  return std::sqrt(float(r.count) * stack.pixel[0] * stack.pixel[1] / 3.14159265f);
}

/// Marks the regions of `a` and `b` that overlap once a's pixels are carried by `direction` (1 or -1) times
/// the motion.
void markMeeting(const LabelRegions& a, const LabelRegions& b, const SliceMotion& motion, float direction,
                 std::vector<char>& meetsA, std::vector<char>& meetsB) {
  for (const RegionRun& run : a.runs)
    for (int x = run.x0; x < run.x1 && !meetsA[size_t(run.region)]; ++x) {
      const SliceMotion::Vector v = motion.at(float(x), float(run.y));
      const int j = b.at(int(std::floor(float(x) + direction * v.x + .5f)),
                         int(std::floor(float(run.y) + direction * v.y + .5f)));
      if (j >= 0) meetsA[size_t(run.region)] = meetsB[size_t(j)] = 1;
    }
}

/// Runs of pixels inside, each as a region of its own.
std::vector<RegionRun> findRuns(const LabelScore& score) {
  const PixelBox& box = score.box;
  std::vector<RegionRun> runs;
  for (int y = box.y0; y < box.y1; ++y) {
    const float* row = &score.values[box.index(box.x0, y)];
    for (int x = 0, w = box.width(); x < w; ++x) {
      if (row[x] <= 0) continue;
      const int x0 = x;
      while (x < w && row[x] > 0) ++x;
      runs.push_back({y, box.x0 + x0, box.x0 + x, int(runs.size())});
    }
  }
  return runs;
}

/// Joins runs that touch each other; the region is the index of its first run.
void joinRuns(std::vector<RegionRun>& runs) {
  const auto alike = [](const RegionRun&, const RegionRun&) { return true; };
  const std::vector<std::uint32_t> first = joinedRuns(runs, Touching::kCorners, alike);
  for (size_t i = 0; i < runs.size(); ++i) runs[i].region = int(first[i]);
}

struct Candidate {
  float cost;
  int a, b;
  bool trusted;
};

}  // namespace

int LabelRegions::at(int x, int y) const {
  const auto after = std::upper_bound(
      runs.begin(), runs.end(), RegionRun{y, x, 0, 0},
      [](const RegionRun& p, const RegionRun& q) { return p.y != q.y ? p.y < q.y : p.x0 < q.x0; });
  if (after == runs.begin()) return -1;
  const RegionRun& run = after[-1];
  return run.y == y && x < run.x1 ? run.region : -1;
}

LabelRegions findRegions(const LabelScore& score) {
  LabelRegions result;
  result.runs = findRuns(score);
  joinRuns(result.runs);
  std::vector<double> sumX, sumY;
  for (size_t i = 0; i < result.runs.size(); ++i) {
    RegionRun& run = result.runs[i];
    if (run.region == int(i)) {
      run.region = int(result.regions.size());
      result.regions.emplace_back(), sumX.push_back(0), sumY.push_back(0);
    } else {
      // an earlier run, whose region is already numbered
      run.region = result.runs[size_t(run.region)].region;
    }
    const size_t id = size_t(run.region), count = size_t(run.x1 - run.x0);
    LabelRegion& r = result.regions[id];
    r.box = hull(r.box, {run.x0, run.y, run.x1, run.y + 1}), r.count += count;
    sumX[id] += 0.5 * double(count) * (run.x0 + run.x1 - 1), sumY[id] += double(count) * run.y;
    const float* row = &score.values[score.box.index(run.x0, run.y)];
    r.depth = std::max(r.depth, *std::max_element(row, row + count));
  }
  for (size_t id = 0; id < result.regions.size(); ++id) {
    LabelRegion& r = result.regions[id];
    r.x = float(sumX[id] / double(r.count)), r.y = float(sumY[id] / double(r.count));
  }
  return result;
}

std::vector<RegionPair> pairRegions(const LabelRegions& ra, const LabelRegions& rb, const SliceMotion& motion,
                                    const ScoreStack& stack, float gap) {
  std::vector<char> tiedA(ra.regions.size(), 0), tiedB(rb.regions.size(), 0);
  markMeeting(ra, rb, motion, 1, tiedA, tiedB), markMeeting(rb, ra, motion, -1, tiedB, tiedA);
  bool any = std::count(tiedA.begin(), tiedA.end(), 1) > 0;
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < tiedA.size(); ++i)
    for (size_t j = 0; j < tiedB.size(); ++j) {
      if (tiedA[i] || tiedB[j]) continue;
      const LabelRegion &p = ra.regions[i], &q = rb.regions[j];
      const float d = std::hypot((p.x - q.x) * stack.pixel[0], (p.y - q.y) * stack.pixel[1]);
      const float rp = radiusOf(p, stack), rq = radiusOf(q, stack);
      candidates.push_back({d + std::abs(rp - rq), int(i), int(j), d <= kSteepestShift * gap + rp + rq});
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

LabelScore regionScore(const LabelScore& score, const LabelRegions& regions, int region,
                       const ScoreStack& stack) {
  LabelScore own;
  own.label = score.label;
  own.box = intersection(regions.regions[size_t(region)].box.grown(1), score.box);
  std::vector<std::uint8_t> mask(own.box.count());
  for (const RegionRun& run : regions.runs)
    if (run.region == region)
      std::fill_n(mask.begin() + std::ptrdiff_t(own.box.index(run.x0, run.y)), run.x1 - run.x0, 1);
  own.values =
      maskDistance(mask, own.box, stack.pixel[0], stack.pixel[1], regions.regions[size_t(region)].depth);
  for (int y = own.box.y0; y < own.box.y1; ++y)
    for (int x = own.box.x0; x < own.box.x1; ++x) {
      float& v = own.values[own.box.index(x, y)];
      const float all = score.values[score.box.index(x, y)];
      v = v > 0 ? all : std::min(v, all);
    }
  return own;
}

}  // namespace slicemorph

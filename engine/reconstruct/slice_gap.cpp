#include "engine/reconstruct/slice_gap.h"

#include "engine/numerics/parallel_each.h"
#include "engine/reconstruct/regions.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

const LabelScore* findLabel(const ScorePlane& plane, int label) {
  const auto it = std::lower_bound(plane.labels.begin(), plane.labels.end(), label,
                                   [](const LabelScore& s, int l) { return s.label < l; });
  return it != plane.labels.end() && it->label == label ? &*it : nullptr;
}

/// Adds the travelling regions of label `l` in gap `g`; `l` becomes the gap's next label.
void addTravellers(const ScoreStack& stack, size_t g, const std::vector<std::vector<LabelRegions>>& regions,
                   GapLabel& l, Gap& gap) {
  const ScorePlane &pa = stack.planes[g], &pb = stack.planes[g + 1];
  const LabelScore *a = findLabel(pa, l.label), *b = findLabel(pb, l.label);
  if (!a || !b) return;
  const LabelRegions& ra = regions[g][size_t(a - pa.labels.data())];
  const LabelRegions& rb = regions[g + 1][size_t(b - pb.labels.data())];
  for (const RegionPair& pair : pairRegions(ra, rb, gap.motion, stack, float(pb.position - pa.position))) {
    const LabelRegion &p = ra.regions[size_t(pair.a)], &q = rb.regions[size_t(pair.b)];
    Traveller t;
    t.label = gap.labels.size(), t.x = q.x - p.x, t.y = q.y - p.y;
    t.a = regionScore(*a, ra, pair.a, stack), t.b = regionScore(*b, rb, pair.b, stack);
    t.thin = std::min(p.depth, q.depth) < std::max(stack.pixel[0], stack.pixel[1]);
    t.box = hull(t.a.box, t.b.box).grown(1);
    l.box = hull(l.box, t.box);
    gap.travellers.push_back(std::move(t));
  }
}

Gap makeGap(const ScoreStack& stack, size_t g, const std::vector<std::vector<LabelRegions>>& regions) {
  Gap gap;
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
          g + k >= 1 && g + k - 1 < stack.planes.size() ? findLabel(stack.planes[g + k - 1], label) : nullptr;
      if (!f) continue;
      l.plane[k] = ScoreField(*f, stack);
      if (k == 1 || k == 2)
        l.box = hull(l.box, f->box), l.depth[k - 1] = *std::max_element(f->values.begin(), f->values.end());
    }
    l.box = l.box.grown(1 + int(std::ceil(most)));
    addTravellers(stack, g, regions, l, gap);
    l.box = intersection(l.box, stack.domain);
    gap.labels.push_back(l);
  }
  return gap;
}

}  // namespace

const GapLabel& labelIn(const Gap& gap, int label) {
  return *std::lower_bound(gap.labels.begin(), gap.labels.end(), label,
                           [](const GapLabel& l, int value) { return l.label < value; });
}

SlicePlan planSlices(ScoreStack stack, const GapRange& wanted) {
  SlicePlan plan{std::move(stack), {}, {}};
  const ScoreStack& s = plan.stack;
  plan.gaps.resize(s.planes.size() - 1);
  const size_t first = wanted.first, end = std::min(wanted.end, plan.gaps.size());
  plan.regions.resize(s.planes.size());
  parallelEach(end + 1 - first, [&](size_t n) {
    for (const LabelScore& l : s.planes[first + n].labels) plan.regions[first + n].push_back(findRegions(l));
  });
  const size_t before = first > 0 ? first - 1 : 0, after = std::min(end + 1, plan.gaps.size());
  parallelEach(after - before, [&](size_t n) {
    const size_t g = before + n;
    if (first <= g && g < end)
      plan.gaps[g] = makeGap(plan.stack, g, plan.regions);
    else
      plan.gaps[g].motion = findMotion(plan.stack, g);
  });
  return plan;
}

}  // namespace slicemorph

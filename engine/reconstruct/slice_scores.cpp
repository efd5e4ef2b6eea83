#include "engine/reconstruct/slice_scores.h"

#include "engine/reconstruct/gap_scores.h"
#include "engine/reconstruct/join_pieces.h"
#include "engine/reconstruct/labels_in_gap.h"
#include "engine/reconstruct/spare_pieces.h"
#include "slicemorph/errors.h"

#include <string>
#include <utility>

namespace slicemorph {

SliceScores::SliceScores(ScoreStack stack, const GapRange& wanted) : plan_(std::make_unique<SlicePlan>()) {
  if (stack.planes.size() < 2)
    throw InputError("at least two planes are needed to interpolate between, got " +
                     std::to_string(stack.planes.size()));
  for (size_t k = 1; k < stack.planes.size(); ++k)
    if (!(stack.planes[k].position > stack.planes[k - 1].position))
      throw InputError("planes must lie at increasing positions, got " +
                       std::to_string(stack.planes[k].position) + " after " +
                       std::to_string(stack.planes[k - 1].position));
  *plan_ = planSlices(std::move(stack), wanted);
}

SliceScores::~SliceScores() = default;

const ScoreStack& SliceScores::stack() const { return plan_->stack; }

ScoreStack SliceScores::takeStack() && { return std::move(plan_->stack); }

std::vector<LabelScore> SliceScores::scoresAt(double position) const {
  const Moment m = momentAt(plan_->stack, position);
  const Gap& gap = plan_->gaps[m.gap];
  std::vector<LabelScore> scores;
  for (const GapLabel& l : gap.labels) {
    LabelScore score{l.label, l.box, std::vector<float>(l.box.count())};
    for (int y = l.box.y0; y < l.box.y1; ++y)
      for (int x = l.box.x0; x < l.box.x1; ++x)
        score.values[l.box.index(x, y)] = wholeScore(*plan_, l, m, float(x), float(y));
    scores.push_back(std::move(score));
  }
  return scores;
}

LabelScore SliceScores::marginAt(double position, int label) const {
  const Moment m = momentAt(plan_->stack, position);
  const Gap& gap = plan_->gaps[m.gap];
  LabelScore margin;
  margin.label = label;
  for (const GapLabel& own : gap.labels) {
    if (own.label != label) continue;
    margin.box = own.box;
    margin.values.resize(own.box.count());
    for (int y = own.box.y0; y < own.box.y1; ++y)
      for (int x = own.box.x0; x < own.box.x1; ++x) {
        const float mine = wholeScore(*plan_, own, m, float(x), float(y));
        float best = gap.labels.size() > 1 ? -1e30f : -mine;
        for (const GapLabel& l : gap.labels)
          if (l.label != label && l.box.contains(x, y))
            best = std::max(best, wholeScore(*plan_, l, m, float(x), float(y)));
        margin.values[own.box.index(x, y)] = best > -1e29f ? 0.5f * (mine - best) : mine;
      }
  }
  return margin;
}

std::vector<int> SliceScores::labelsBetween(const std::vector<double>& positions) const {
  std::vector<int> labels = labelsInGap(*plan_, positions);
  if (positions.empty()) return labels;
  const size_t gap = momentAt(plan_->stack, positions[0]).gap;
  joinPieces(*plan_, gap, positions, labels);
  dropSparePieces(*plan_, gap, positions, labels);
  return labels;
}

}  // namespace slicemorph

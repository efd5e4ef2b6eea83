#include "engine/reconstruct/piece_changes.h"

#include "engine/reconstruct/gap_scores.h"

#include <algorithm>
#include <utility>

namespace slicemorph {

namespace {

/// Longest path, in pixels.
constexpr int kLongestPath = 4;
/// What a pixel of a path costs at least, as a share of the shorter pixel side, so that of free ones the shortest is taken.
constexpr float kStepCost = 0.01f;

constexpr PiecePixel kRing[8] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

PiecePixel beside(PiecePixel p, PiecePixel d) { return {p.x + d.x, p.y + d.y}; }

}  // namespace

float PieceChanges::scoreAt(int label, PiecePixel p) const {
  const Gap& gap = plan_->gaps[moment_.gap];
  return wholeScore(*plan_, labelIn(gap, label), moment_, float(p.x), float(p.y));
}

float PieceChanges::costOfLoss(const PiecePixels& piece, int label, float most) const {
  std::vector<int> around;
  for (const PiecePixel& p : piece)
    for (const PiecePixel& d : kPixelSides) {
      const int other = valueAt(p.x + d.x, p.y + d.y);
      if (other >= 0 && other != label) around.push_back(other);
    }
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  if (around.empty()) return kNeverCost;
  float cost = 0;
  for (const PiecePixel& p : piece) {
    float other = -kNeverCost;
    for (int a : around) other = std::max(other, scoreAt(a, p));
    cost += std::max(0.0f, scoreAt(label, p) - other);
    if (cost >= most) return kNeverCost;
  }
  return cost;
}

void PieceChanges::giveAway(PiecePixels piece, int label) {
  // From its rim inwards, each pixel goes to the best of the labels beside it.
  while (!piece.empty()) {
    PiecePixels left;
    std::vector<std::pair<PiecePixel, int>> given;
    for (const PiecePixel& p : piece) {
      std::pair<float, int> best{-kNeverCost, -1};
      for (const PiecePixel& d : kPixelSides) {
        const int other = valueAt(p.x + d.x, p.y + d.y);
        if (other >= 0 && other != label) best = std::max(best, {scoreAt(other, p), other});
      }
      if (best.second < 0)
        left.push_back(p);
      else
        given.emplace_back(p, best.second);
    }
    if (given.empty()) return;
    for (const auto& [p, other] : given) at(p) = other;
    piece.swap(left);
  }
}

/// Whether a pixel's label stays as whole as it is without the pixel, as far as its eight neighbours tell.
bool PieceChanges::isSpare(PiecePixel p) const {
  const int label = valueAt(p.x, p.y);
  bool same[8];
  for (int k = 0; k < 8; ++k) same[k] = valueAt(p.x + kRing[k].x, p.y + kRing[k].y) == label;
  // Counts where, going round, an unbroken part of the label ends; even numbers are sides, which touch each other across
  // a corner.
  int parts = 0;
  for (int k = 0; k < 8; k += 2) {
    parts += same[k] && !same[k + 1] && !same[(k + 2) % 8];
    parts += same[k + 1] && !same[(k + 2) % 8];
  }
  return parts == 1;
}

std::vector<int> PieceChanges::take(const PiecePath& path, int label) {
  std::vector<int> before;
  for (const PiecePixel& p : path.pixels) before.push_back(std::exchange(at(p), label));
  return before;
}

void PieceChanges::putBack(const PiecePath& path, const std::vector<int>& labels) {
  for (size_t i = 0; i < labels.size(); ++i) at(path.pixels[i]) = labels[i];
}

PiecePath PieceChanges::pathFrom(const PiecePixels& piece, int label, float most, bool sparing,
                                 const std::function<bool(PiecePixel)>& ends) const {
  PixelBox box;
  for (const PiecePixel& p : piece) box.add(p.x, p.y);
  box = intersection(box.grown(kLongestPath), domain_);
  // Per pixel the cheapest way there and the pixel before it, in sweeps as many as a path has pixels.
  std::vector<float> cost(box.count(), kNeverCost);
  std::vector<int> from(box.count(), -1);
  for (const PiecePixel& p : piece) cost[box.index(p.x, p.y)] = 0;
  PiecePath best;
  best.cost = most;
  const float least = kStepCost * std::min(plan_->stack.pixel[0], plan_->stack.pixel[1]);
  PiecePixels front = piece;
  for (int length = 0; length < kLongestPath && !front.empty(); ++length) {
    const std::vector<float> before = cost;
    PiecePixels next;
    for (const PiecePixel& p : front)
      for (const PiecePixel& d : kPixelSides) {
        const PiecePixel q = beside(p, d);
        if (!box.contains(q.x, q.y) || valueAt(q.x, q.y) == label || (sparing && !isSpare(q))) continue;
        const size_t to = box.index(q.x, q.y), here = box.index(p.x, p.y);
        const float sum =
            before[here] + least + std::max(0.0f, scoreAt(valueAt(q.x, q.y), q) - scoreAt(label, q));
        if (sum >= cost[to] || sum >= best.cost) continue;
        cost[to] = sum, from[to] = int(here), next.push_back(q);
        if (!ends(q)) continue;
        best.cost = sum, best.pixels.clear();
        for (int at = int(to); from[size_t(at)] >= 0; at = from[size_t(at)])
          best.pixels.push_back({box.x0 + at % box.width(), box.y0 + at / box.width()});
      }
    front.swap(next);
  }
  if (best.pixels.empty()) best.cost = kNeverCost;
  return best;
}

}  // namespace slicemorph

#include "engine/reconstruct/spare_pieces.h"

#include "engine/numerics/disjoint_sets.h"
#include "engine/reconstruct/piece_changes.h"
#include "engine/reconstruct/slice_pieces.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

namespace slicemorph {

namespace {

/// How often loose pieces are looked for: one may be joined to another that is loose itself.
constexpr int kLooseRounds = 2;

/// Pixels of a label, by slice.
using PiecesBySlice = std::map<size_t, PiecePixels>;

/// The change that costs least of those tried.
struct PieceChange {
  float cost = kNeverCost;
  size_t slice = 0;
  PiecePixels piece;
  PiecePath path;  ///< none: the piece is given away
};

/// A piece's pixels, to be looked up.
class PixelSet {
 public:
  PixelSet(const PiecePixels& pixels, const PixelBox& domain) : domain_(domain) {
    for (const PiecePixel& p : pixels) at_.push_back(domain.index(p.x, p.y));
    std::sort(at_.begin(), at_.end());
  }
  bool has(int x, int y) const {
    return domain_.contains(x, y) && std::binary_search(at_.begin(), at_.end(), domain_.index(x, y));
  }

 private:
  PixelBox domain_;
  std::vector<size_t> at_;
};

/// One gap's slices, between its two planes.
class SparePieces {
 public:
  SparePieces(const SlicePlan& plan, size_t g, const std::vector<double>& positions, std::vector<int>& labels)
      : plan_(plan), gap_(plan.gaps[g]), domain_(plan.stack.domain) {
    for (size_t side = 0; side < 2; ++side) planes_[side] = painted(g + side);
    slices_.push_back(planes_[0].data());
    for (size_t i = 0; i < positions.size(); ++i) {
      slices_.push_back(&labels[i * domain_.count()]);
      moments_.push_back(momentAt(plan.stack, positions[i]));
    }
    slices_.push_back(planes_[1].data());
  }

  /// Leaves no more pieces of a label on a slice than on the plane that has more of them.
  void limit(Touching touching) {
    touching_ = touching, most_ = mostPieces();
    for (size_t i = 1; i + 1 < slices_.size(); ++i) {
      std::vector<PieceRun> runs = piecesOf(i);
      std::vector<size_t> count = countOf(runs);
      for (size_t l = 0; l < count.size(); ++l)
        while (count[l] > most_[l] && dropOne(i, runs, count, gap_.labels[l].label))
          runs = piecesOf(i), count = countOf(runs);
    }
  }

  /// Ties pieces that no plane holds to those that one does, or drops them.
  void tie() {
    touching_ = Touching::kSides, most_ = mostPieces();
    for (int round = 0; round < kLooseRounds; ++round) {
      const std::vector<std::pair<int, PiecesBySlice>> loose = loosePieces();
      for (const auto& [label, pieces] : loose) tieOne(label, pieces);
      if (loose.empty()) return;
    }
  }

 private:
  /// The labels of a plane.
  std::vector<int> painted(size_t k) const {
    std::vector<int> slice(domain_.count(), 0);
    for (size_t l = 0; l < plan_.regions[k].size(); ++l)
      for (const RegionRun& run : plan_.regions[k][l].runs)
        std::fill_n(&slice[domain_.index(run.x0, run.y)], run.x1 - run.x0,
                    plan_.stack.planes[k].labels[l].label);
    return slice;
  }
  std::vector<PieceRun> piecesOf(size_t slice) const {
    std::vector<PieceRun> runs = findRuns(domain_, slices_[slice]);
    joinToPieces(runs, touching_);
    return runs;
  }
  /// Pieces per label of the gap.
  std::vector<size_t> countOf(const std::vector<PieceRun>& runs) const {
    std::vector<size_t> count(gap_.labels.size(), 0);
    for (size_t i = 0; i < runs.size(); ++i)
      if (runs[i].piece == i) ++count[size_t(&labelIn(gap_, runs[i].label) - gap_.labels.data())];
    return count;
  }
  /// Pieces per label of the gap, on the plane that has more of them.
  std::vector<size_t> mostPieces() const {
    std::vector<size_t> most = countOf(piecesOf(0));
    const std::vector<size_t> other = countOf(piecesOf(slices_.size() - 1));
    for (size_t l = 0; l < most.size(); ++l) most[l] = std::max(most[l], other[l]);
    return most;
  }
  int valueAt(size_t slice, int x, int y) const {
    return domain_.contains(x, y) ? slices_[slice][domain_.index(x, y)] : -1;
  }
  PieceChanges changesOf(size_t slice) const { return {plan_, moments_[slice - 1], slices_[slice]}; }
  /// Takes a path, unless without its pixels another label has one more piece, and more than it may, or none where
  /// it is on both planes.
  /// `before`: pieces per label of the slice as it is.
  bool takePath(size_t slice, const PiecePath& path, int label, const std::vector<size_t>& before) {
    PieceChanges changes = changesOf(slice);
    const std::vector<int> labels = changes.take(path, label);
    const std::vector<size_t> after = countOf(piecesOf(slice));
    for (size_t l = 0; l < after.size(); ++l)
      if (gap_.labels[l].label != label && (after[l] > std::max(before[l], most_[l]) ||
                                            (after[l] == 0 && before[l] > 0 && isOnBoth(gap_.labels[l])))) {
        changes.putBack(path, labels);
        return false;
      }
    return true;
  }
  bool isBeside(size_t slice, PiecePixel p, int label, const PixelSet& own) const {
    for (const PiecePixel& d : kPixelSides)
      if (valueAt(slice, p.x + d.x, p.y + d.y) == label && !own.has(p.x + d.x, p.y + d.y)) return true;
    return false;
  }

  /// Makes the label's pieces on a slice one fewer where that costs least.
  bool dropOne(size_t slice, const std::vector<PieceRun>& runs, const std::vector<size_t>& count, int label) {
    std::map<std::uint32_t, PiecePixels> found;
    for (const PieceRun& run : runs)
      if (run.label == label)
        for (int x = run.x0; x < run.x1; ++x) found[run.piece].push_back({x, run.y});
    std::vector<PiecePixels> pieces;
    for (auto& [name, pixels] : found) pieces.push_back(std::move(pixels));
    std::stable_sort(pieces.begin(), pieces.end(),
                     [](const PiecePixels& a, const PiecePixels& b) { return a.size() < b.size(); });
    pieces.pop_back();  // the largest: paths from the others lead to it
    for (const bool sparing : {false, true}) {
      const PieceChange best = cheapestOf(slice, pieces, label, sparing);
      if (best.cost == kNeverCost) return false;
      if (best.path.pixels.empty())
        changesOf(slice).giveAway(best.piece, label);
      else if (!takePath(slice, best.path, label, count))
        continue;
      return true;
    }
    return false;
  }
  PieceChange cheapestOf(size_t slice, const std::vector<PiecePixels>& pieces, int label,
                         bool sparing) const {
    const PieceChanges changes = changesOf(slice);
    PieceChange best;
    for (const PiecePixels& piece : pieces) {
      const float cost = changes.costOfLoss(piece, label, best.cost);
      if (cost < best.cost) best = {cost, slice, piece, {}};
      const PixelSet own(piece, domain_);
      const auto ends = [&](PiecePixel p) { return isBeside(slice, p, label, own); };
      PiecePath path = changes.pathFrom(piece, label, best.cost, sparing, ends);
      if (path.cost < best.cost) best = {path.cost, slice, {}, std::move(path)};
    }
    return best;
  }

  /// Pieces, from slice to slice, that do not hang together with any on a plane; with their label.
  std::vector<std::pair<int, PiecesBySlice>> loosePieces() const {
    std::vector<PieceRun> runs;
    std::vector<size_t> first;
    for (size_t i = 0; i < slices_.size(); ++i) {
      first.push_back(runs.size());
      std::vector<PieceRun> own = piecesOf(i);
      for (PieceRun& run : own) run.piece += std::uint32_t(first.back());
      runs.insert(runs.end(), own.begin(), own.end());
    }
    first.push_back(runs.size());
    DisjointSets pieces(runs.size());
    for (size_t i = 0; i < runs.size(); ++i) pieces.join(runs[i].piece, std::uint32_t(i));
    for (size_t s = 0; s + 1 < slices_.size(); ++s)
      for (size_t i = first[s], j = first[s + 1]; i < first[s + 1];) {
        if (runs[i].label == runs[j].label) pieces.join(std::uint32_t(i), std::uint32_t(j));
        // Slices are covered by their runs, so that row by row those that end first come first.
        const int endsBefore = runs[i].x1 - runs[j].x1;
        i += endsBefore <= 0, j += endsBefore >= 0;
      }
    std::vector<char> held(runs.size(), 0);
    for (size_t s : {size_t(0), slices_.size() - 1})
      for (size_t i = first[s]; i < first[s + 1]; ++i) held[pieces.find(std::uint32_t(i))] = 1;
    std::map<std::uint32_t, std::pair<int, PiecesBySlice>> loose;
    for (size_t s = 1; s + 1 < slices_.size(); ++s)
      for (size_t i = first[s]; i < first[s + 1]; ++i) {
        const std::uint32_t piece = pieces.find(std::uint32_t(i));
        if (held[piece]) continue;
        auto& [label, bySlice] = loose[piece];
        label = runs[i].label;
        for (int x = runs[i].x0; x < runs[i].x1; ++x) bySlice[s].push_back({x, runs[i].y});
      }
    std::vector<std::pair<int, PiecesBySlice>> found;
    for (auto& [name, pixels] : loose) found.push_back(std::move(pixels));
    return found;
  }

  /// Pieces without pixels that have been given to others since they were found.
  PiecesBySlice stillOf(int label, PiecesBySlice pieces) const {
    for (auto piece = pieces.begin(); piece != pieces.end();) {
      auto& [slice, pixels] = *piece;
      const auto gone = [&, s = slice](const PiecePixel& p) { return valueAt(s, p.x, p.y) != label; };
      pixels.erase(std::remove_if(pixels.begin(), pixels.end(), gone), pixels.end());
      piece = pixels.empty() ? pieces.erase(piece) : std::next(piece);
    }
    return pieces;
  }

  void tieOne(int label, const PiecesBySlice& found) {
    const PiecesBySlice pieces = stillOf(label, found);
    if (pieces.empty()) return;
    float loss = kNeverCost;
    if (mayGo(label, pieces)) {
      loss = 0;
      for (const auto& [slice, pixels] : pieces) {
        const float cost = changesOf(slice).costOfLoss(pixels, label, kNeverCost);
        loss = cost < kNeverCost ? loss + cost : kNeverCost;
      }
    }
    for (const bool sparing : {false, true}) {
      const PieceChange tie = cheapestTie(label, pieces, loss, sparing);
      if (tie.path.pixels.empty()) break;
      if (takePath(tie.slice, tie.path, label, countOf(piecesOf(tie.slice)))) return;
    }
    if (loss < kNeverCost)
      for (const auto& [slice, pixels] : pieces) changesOf(slice).giveAway(pixels, label);
  }
  PieceChange cheapestTie(int label, const PiecesBySlice& pieces, float most, bool sparing) const {
    PieceChange best;
    best.cost = most;
    for (const auto& [slice, pixels] : pieces) {
      const PixelSet own(pixels, domain_);
      const auto ends = [&, s = slice](PiecePixel p) {
        return valueAt(s - 1, p.x, p.y) == label || valueAt(s + 1, p.x, p.y) == label ||
               isBeside(s, p, label, own);
      };
      PiecePath path = changesOf(slice).pathFrom(pixels, label, best.cost, sparing, ends);
      if (path.cost < best.cost) best = {path.cost, slice, {}, std::move(path)};
    }
    return best;
  }

  static bool isOnBoth(const GapLabel& label) { return bool(label.plane[1]) && bool(label.plane[2]); }
  /// Whether every slice keeps some of a label without these pieces, or need not.
  bool mayGo(int label, const PiecesBySlice& pieces) const {
    if (!isOnBoth(labelIn(gap_, label))) return true;
    for (const auto& [slice, pixels] : pieces)
      if (size_t(std::count(slices_[slice], slices_[slice] + domain_.count(), label)) <= pixels.size())
        return false;
    return true;
  }

  const SlicePlan& plan_;
  const Gap& gap_;
  PixelBox domain_;
  std::vector<int> planes_[2];
  std::vector<int*> slices_;     ///< the first and the last are the planes
  std::vector<Moment> moments_;  ///< of the others
  Touching touching_ = Touching::kSides;
  std::vector<size_t> most_;  ///< pieces per label of the gap
};

}  // namespace

void dropSparePieces(const SlicePlan& plan, size_t g, const std::vector<double>& positions,
                     std::vector<int>& labels) {
  if (positions.empty()) return;
  SparePieces spare(plan, g, positions, labels);
  spare.tie();
  spare.limit(Touching::kSides);
  spare.limit(Touching::kCorners);
}

}  // namespace slicemorph

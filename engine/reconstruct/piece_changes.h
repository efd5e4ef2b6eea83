#pragma once

#include "engine/reconstruct/slice_gap.h"
#include "engine/reconstruct/slice_moment.h"

#include <functional>
#include <limits>

namespace slicemorph {

struct PiecePixel {
  int x, y;
};
using PiecePixels = std::vector<PiecePixel>;

/// The steps to the pixels that share a side.
constexpr PiecePixel kPixelSides[4] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

/// What no change of a slice costs.
constexpr float kNeverCost = std::numeric_limits<float>::max();

/// A path by which a piece of a label is joined to what it is to hang together with.
struct PiecePath {
  float cost = kNeverCost;
  PiecePixels pixels;
};

/// Changes to the pieces of the labels of one slice in a gap. What a change costs is what the scores of the pixels' labels
/// lose by it.
class PieceChanges {
 public:
  /// `slice`: labels of the plan's domain, row by row.
  PieceChanges(const SlicePlan& plan, const Moment& moment, int* slice)
      : plan_(&plan), moment_(moment), slice_(slice), domain_(plan.stack.domain) {}

  /// The label of a pixel; -1 beyond the slice.
  int valueAt(int x, int y) const { return domain_.contains(x, y) ? slice_[domain_.index(x, y)] : -1; }

  /// What it costs to give a piece away; kNeverCost if that is no less than `most`.
  float costOfLoss(const PiecePixels& piece, int label, float most) const;
  /// Gives a piece to the labels around it.
  void giveAway(PiecePixels piece, int label);

  /// The cheapest path of few pixels from a piece to a pixel where `ends` is true. Its cost is below `most`, or
  /// kNeverCost. `sparing`: only through pixels without which the piece that they are of hangs together all the same, as
  /// far as their eight neighbours tell.
  PiecePath pathFrom(const PiecePixels& piece, int label, float most, bool sparing,
                     const std::function<bool(PiecePixel)>& ends) const;
  /// Gives the pixels of a path to a label; returns those they had.
  std::vector<int> take(const PiecePath& path, int label);
  void putBack(const PiecePath& path, const std::vector<int>& labels);

 private:
  int& at(PiecePixel p) { return slice_[domain_.index(p.x, p.y)]; }
  float scoreAt(int label, PiecePixel p) const;
  bool isSpare(PiecePixel p) const;

  const SlicePlan* plan_;
  Moment moment_;
  int* slice_;
  PixelBox domain_;
};

}  // namespace slicemorph

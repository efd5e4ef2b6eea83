#pragma once

#include "engine/numerics/pixel_box.h"

#include <limits>
#include <memory>
#include <vector>

namespace slicemorph {

/// One label's score on a plane: signed distance to its contour, positive inside, world units, row by row
/// over `box`.
struct LabelScore {
  int label = 0;
  PixelBox box;
  std::vector<float> values;
};

/// A given plane with the labels drawn on it, ascending. A label's box contains its inside plus a rim of one
/// pixel or more; there is no rim at the domain's border, beyond which the label is assumed to continue.
struct ScorePlane {
  double position = 0;  ///< along the stack, world units
  std::vector<LabelScore> labels;
};

/// Given planes at increasing positions; the gaps may differ.
struct ScoreStack {
  float pixel[2] = {1, 1};  ///< side lengths, world units
  PixelBox domain;          ///< all pixels
  std::vector<ScorePlane> planes;
};

/// Some of a stack's gaps: gap g lies between planes g and g + 1.
struct GapRange {
  size_t first = 0, end = std::numeric_limits<size_t>::max();  ///< one past the last
};

struct SlicePlan;

/// A stack of given planes, prepared for queries between them: labels are carried along a smooth motion in
/// the plane from plane to plane, and their scores are blended by a limited cubic through four planes.
/// Between planes a score is a distance near the contour and levels off at about a gap's length.
class SliceScores {
 public:
  /// Throws InputError for fewer than two planes, or if positions do not increase. `wanted`: queries will be within
  /// these gaps; of the planes beyond only the one before and the one after them matter.
  explicit SliceScores(ScoreStack stack, const GapRange& wanted = {});
  ~SliceScores();

  const ScoreStack& stack() const;
  /// The planes back, when no more is asked.
  ScoreStack takeStack() &&;

  /// Scores of all labels that may be present at a position between the first and the last plane, ascending;
  /// each over a box outside of which the label loses.
  std::vector<LabelScore> scoresAt(double position) const;

  /// Half the difference between the score of `label` and the best other label's. An empty box if the label
  /// cannot be present.
  LabelScore marginAt(double position, int label) const;

  /// The label of highest score for every pixel of the domain, at the ascending positions of all slices of one gap, slice
  /// after slice; near ties go to the lowest label. A label on both neighbouring planes keeps at least the
  /// pixel where it comes closest to winning, and its regions there are joined as in join_pieces.h. Pieces that the two
  /// planes do not account for are removed as in spare_pieces.h.
  std::vector<int> labelsBetween(const std::vector<double>& positions) const;

 private:
  std::unique_ptr<SlicePlan> plan_;
};

}  // namespace slicemorph

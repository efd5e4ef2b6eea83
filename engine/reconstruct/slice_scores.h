#pragma once

#include "engine/numerics/pixel_box.h"

#include <memory>
#include <vector>

namespace slicemorph {

/// One label's score on a plane: signed distance to its contour, positive inside, world units; row by row
/// over `box`.
struct LabelScore {
  int label = 0;
  PixelBox box;
  std::vector<float> values;
};

/// A given plane: every label drawn on it, ascending; `box` holds the label's inside with a rim of one pixel
/// or more (none where it meets the domain's border, beyond which it is taken to go on).
struct ScorePlane {
  double position = 0;  ///< along the stack, world units
  std::vector<LabelScore> labels;
};

/// Given planes at increasing positions, any gaps.
struct ScoreStack {
  float pixel[2] = {1, 1};  ///< sides, world units
  PixelBox domain;          ///< all there is
  std::vector<ScorePlane> planes;
};

struct SlicePlan;

/// A stack of given planes made ready to be asked what lies between them: the labels are carried along a
/// smooth planar motion from plane to plane and their scores blended there by a limited cubic through four
/// planes. A score read between planes is a distance near the contour and levels off beyond a gap's length.
class SliceScores {
 public:
  /// Throws InputError for fewer than two planes or positions that do not increase.
  explicit SliceScores(ScoreStack stack);
  ~SliceScores();

  const ScoreStack& stack() const;

  /// Scores of every label that may be at a position from the first plane to the last, ascending; each over a
  /// box outside of which it loses.
  std::vector<LabelScore> scoresAt(double position) const;

  /// Half of what `label` has over the best other label; as `scoresAt`, an empty box where the label cannot
  /// be.
  LabelScore marginAt(double position, int label) const;

  /// The label of highest score of every pixel of the domain at ascending positions inside one gap, one slice
  /// after the other; nearly equal ones go to the lowest label. A label that both neighbouring planes have
  /// keeps at least the pixel where it comes closest to winning.
  std::vector<int> labelsBetween(const std::vector<double>& positions) const;

 private:
  std::unique_ptr<SlicePlan> plan_;
};

}  // namespace slicemorph

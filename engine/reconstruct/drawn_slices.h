#pragma once

#include "engine/reconstruct/label_slices.h"

#include <map>
#include <utility>

namespace slicemorph {

/// Tells from the labels' places whether slices without a label state that it is absent there, or were not drawn.
/// Gathered slice by slice, so that the whole map need not be in memory.
class DrawnSlices {
 public:
  /// Adds a slice that holds labels; `at`: its number, ascending.
  void add(const LabelSlice& slice, int at);

  /// Whether an outline of some label lies over its next one, beyond an empty slice: one body, on which that slice
  /// was left out.
  bool goesOnOver(int empty) const;

  /// The labels that some of the given slices state nothing about. A label's place on these is empty, its parts on
  /// the slices before and after lie over each other, and they are not its own: they hold none of the labels that
  /// were drawn together with it, or it was drawn in steps of its own.
  std::vector<OwnSlices> ownSlices(const std::vector<int>& given) const;

 private:
  struct Run {
    int y, x0, x1;
  };
  /// A slice without the label, between two that hold it.
  struct Skip {
    int at;
    bool empty;   ///< most of the label's place is background
    bool shared;  ///< it holds labels of the slice before or after
    bool body = false;
  };
  struct Label {
    std::vector<int> at;
    std::vector<Run> last;             ///< on the last slice that holds it
    std::vector<int> beside, skipped;  ///< labels on that slice; on those since
    std::vector<Skip> skips,
        pending;               ///< pending: since the last slice that holds it
    bool consecutive = false;  ///< on two slices that follow each other
  };
  /// Compares the labels' last outlines with a slice. `now`: its labels' pixels.
  void look(const std::vector<int>& pixels, int width, const std::map<int, size_t>& now, int at);

  std::map<int, Label> labels_;
  std::vector<int> at_;
  std::vector<std::pair<int, int>>
      bodies_;  ///< slices, not neighbours, with outlines that lie over each other
};

}  // namespace slicemorph

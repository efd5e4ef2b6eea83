#pragma once

#include "engine/reconstruct/label_slices.h"

#include <functional>

namespace slicemorph {

/// The slices that were filled into the gap after the given slice `gap`.
struct FilledGap {
  size_t gap = 0;
  int slices = 0;
  std::vector<int> ranks;  ///< of labels, slice after slice, x fastest
};

/// Fills the gaps between given slices from the first to the last, some at a time, so that only the planes around them
/// are in memory.
class GapFiller {
 public:
  /// `ranked`: as rankLabels(). Throws InputError for fewer than two given slices, or if they do not ascend within the
  /// lattice.
  GapFiller(const ImageLattice& lattice, GivenSlices given, std::vector<double> ranked);

  /// The gaps that fill() takes next: as many as give all threads work.
  GapRange next() const;
  bool done() const { return filled_ + 1 == given_.at.size(); }
  /// Number of given slices, from the first, that must be there for them.
  size_t slicesNeeded() const;

  /// Asks for each given slice once, in parallel, by its number. `put` takes the results, from any thread.
  void fill(const std::function<LabelSlice(size_t)>& slice, const std::function<void(FilledGap)>& put);

 private:
  GivenSlices given_;
  std::vector<double> ranked_;
  double spacing_;
  ScoreStack stack_;       ///< with the planes around the gaps that come next
  size_t firstPlane_ = 0;  ///< number of the stack's first plane
  size_t filled_ = 0;      ///< gaps
};

/// Writes a gap's slices into an image's values, from slice `first` on.
void paintGap(const FilledGap& gap, const std::vector<double>& ranked, const SliceLayout& layout, int first,
              ImageValues& to);

/// A dense map from sparse slices: the slices between the given ones are filled in, the others are kept. Ties
/// between scores go to the label with fewer pixels on the given slices.
Image interpolateLabels(Image labels, const GivenSlices& given);

}  // namespace slicemorph

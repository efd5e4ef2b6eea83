#pragma once

#include "engine/reconstruct/slice_scores.h"
#include "slicemorph/image.h"

#include <array>

namespace slicemorph {

/// The slices that tell where one label is and is not, from its first to its last.
struct OwnSlices {
  int label = 0;
  std::vector<int> at;  ///< ascending
};

/// The slices of a label image that tell where labels are and are not.
struct GivenSlices {
  int axis = 2;                     ///< array axis: 0, 1 or 2
  std::vector<int> at;              ///< ascending
  std::vector<OwnSlices> own = {};  ///< of labels that some of these slices state nothing about
};

/// Throws InputError for fewer than two given slices, or if they do not ascend within the lattice.
void checkGivenSlices(const ImageLattice& lattice, const GivenSlices& given);

/// Which slices of a map contain a label, along every axis; gathered slab by slab, so that the whole need not be in
/// memory.
class LabelledSlices {
 public:
  /// `size`: of the whole map.
  explicit LabelledSlices(const openvdb::Coord& size);
  /// Adds the slices along k that follow those added before. Throws InputError if values are not integers.
  void add(const ImageValues& slab);
  /// Per slice along an axis: whether it contains a label.
  const std::vector<char>& along(int axis) const { return found_[size_t(axis)]; }

 private:
  openvdb::Coord size_;
  int added_ = 0;  ///< slices along k
  std::array<std::vector<char>, 3> found_;
};

/// Finds the axis and the given slices of a label map. If, along some axis, all labelled slices are a
/// multiple of n > 1 apart, the axis with the largest n is chosen, and every n-th slice from the first
/// labelled to the last counts as given; an empty one states that nothing is there. Otherwise the labelled
/// slices are given, along the axis with the most empty slices between labelled ones. `axis` -1: to be found;
/// `every` 0: n is to be found, else it is n. Throws InputError if values are not integers, nothing is
/// labelled, only one slice is labelled, or no slice is missing in between.
GivenSlices findGivenSlices(const LabelledSlices& slices, int axis = -1, int every = 0);

/// Where the pixels of slices lie in an image's values; x fastest.
struct SliceLayout {
  int width, height;
  size_t x, y, slice;  ///< strides
};
/// In-plane axes are in array order.
SliceLayout layoutOf(const ImageLattice& lattice, int axis);

/// A slice of labels in memory.
struct LabelSlice {
  const ImageValues& values;
  SliceLayout layout;
  int at;
};

/// How many pixels of each label a slice has, in the order of appearance.
struct LabelCount {
  std::vector<int> values;
  std::vector<size_t> count;
};
LabelCount countLabels(const LabelSlice& slice);

/// Labels by rank: in ascending order of their number of pixels on all given slices, ties by first appearance, so that
/// no later decision depends on the numbers.
std::vector<double> rankLabels(const std::vector<LabelCount>& slices);
std::vector<double> rankLabels(const Image& labels, const GivenSlices& given);

/// A stack without planes for slices along an axis.
ScoreStack emptyStack(const ImageLattice& lattice, int axis);
/// A slice as scores of its labels' ranks. `position`: along the stack.
ScorePlane scoredPlane(const LabelSlice& slice, const std::vector<double>& ranked, const ScoreStack& stack,
                       double position);

/// The given slices as scores.
struct RankedSlices {
  ScoreStack stack;            ///< in-plane axes in array order; positions: slice number times spacing
  std::vector<double> values;  ///< the image's value for each rank
};
RankedSlices rankSlices(const Image& labels, const GivenSlices& given);

}  // namespace slicemorph

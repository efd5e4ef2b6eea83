#pragma once

#include "engine/reconstruct/slice_scores.h"
#include "slicemorph/image.h"

namespace slicemorph {

/// The slices of a label image that contain labels.
struct GivenSlices {
  int axis = 2;         ///< array axis: 0, 1 or 2
  std::vector<int> at;  ///< ascending
};

/// Finds the axis and the given slices of a label map. If, along some axis, all labelled slices are a
/// multiple of n > 1 apart, the axis with the largest n is chosen, and every n-th slice from the first
/// labelled to the last counts as given; an empty one states that nothing is there. Otherwise the labelled
/// slices are given, along the axis with the most empty slices between labelled ones. `axis` -1: to be found;
/// `every` 0: n is to be found, else it is n. Throws InputError if values are not integers, nothing is
/// labelled, only one slice is labelled, or no slice is missing in between.
GivenSlices findGivenSlices(const Image& labels, int axis = -1, int every = 0);

/// The given slices as scores. Label numbers are replaced by ranks, ordered by number of pixels (ascending),
/// so that no later decision depends on the numbers.
struct RankedSlices {
  ScoreStack stack;            ///< in-plane axes in array order; positions: slice number times spacing
  std::vector<double> values;  ///< the image's value for each rank
};
RankedSlices rankSlices(const Image& labels, const GivenSlices& given);

/// A dense map from sparse slices: the slices between the given ones are filled in, the others are kept. Ties
/// between scores go to the label with fewer pixels on the given slices.
Image interpolateLabels(const Image& labels, const GivenSlices& given);

}  // namespace slicemorph

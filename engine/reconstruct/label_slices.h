#pragma once

#include "engine/reconstruct/slice_scores.h"
#include "slicemorph/image.h"

namespace slicemorph {

/// Which slices of a label image hold the drawing.
struct GivenSlices {
  int axis = 2;         ///< array axis: 0, 1 or 2
  std::vector<int> at;  ///< ascending
};

/// Finds axis and given slices of a label map. Where along an axis only slices of one residue modulo n > 1
/// hold labels, the largest such n of all the axes is the drawing's rhythm, and every slice of that residue
/// from the first labelled to the last counts as given: one that is empty says that nothing is there.
/// Otherwise the labelled slices are given, along the axis that has most empty slices between labelled ones.
/// `axis` -1: found; `every` 0: found, else that rhythm is taken. Throws InputError where values are no
/// integers, nothing is labelled, one slice only is given, or none is missing between them.
GivenSlices findGivenSlices(const Image& labels, int axis = -1, int every = 0);

/// Labels of the given slices as scores: label numbers become ranks, by ascending count of pixels on them, so
/// that nothing that follows can depend on the numbers.
struct RankedSlices {
  ScoreStack stack;            ///< in-plane axes in their order, positions: slice number times spacing
  std::vector<double> values;  ///< the image's value of every rank
};
RankedSlices rankSlices(const Image& labels, const GivenSlices& given);

/// A dense map from sparse slices: the slices between the given ones are filled in, all else stays as it is.
/// Equal scores go to the label with fewer pixels on the given slices.
Image interpolateLabels(const Image& labels, const GivenSlices& given);

}  // namespace slicemorph

#pragma once

#include "engine/reconstruct/label_slices.h"

namespace slicemorph {

/// Tells labels from grey values in an image of slices, given slab by slab: labels are whole numbers that are mostly like
/// their neighbours along one axis at least, as looksLikeLabels() asks of dense maps along all. Slices of labels may lie
/// across any axis, with nothing between.
class ValuesSeen {
 public:
  void add(const ImageValues& slab, const openvdb::Coord& size);
  bool looksDrawn() const;

 private:
  bool fractions_ = false;
  double first_ = 0;                                   ///< a value that is not 0
  bool others_ = false;                                ///< than 0 and that one
  double pairs_[3] = {0, 0, 0}, same_[3] = {0, 0, 0};  ///< of neighbours, along each axis
};

/// Which slices along an axis hold more than one value: a slice of one value alone was not given. Same numbering as
/// LabelledSlices::along().
std::vector<char> slicesWithValues(const Image& grey, int axis);

/// A dense grey image: the slices between the given ones are made of the two next to them, whose values move along a
/// smooth motion in the plane that is found from the values; where they do not match so, they are blended where they
/// are. Given slices are kept to the bit, and so are the ones beyond the first and the last. Whole numbers are
/// rounded. Throws InputError for fewer than two given slices, or if they do not ascend within the image.
Image interpolateGrey(Image grey, const GivenSlices& given);

}  // namespace slicemorph

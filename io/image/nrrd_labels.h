#pragma once

#include "slicemorph/io/image_header.h"

#include <map>
#include <string>
#include <vector>

namespace slicemorph {

/// Names and colours of the labels of one layer of a 3D Slicer segmentation, from its keys SegmentN_LabelValue, _Layer,
/// _Name and _Color (Slicer's documentation, "Segmentations", file format). None of other files.
std::vector<LabelName> labelsOfNrrd(const std::map<std::string, std::string>& keys, int layer);

}  // namespace slicemorph

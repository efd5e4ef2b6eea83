#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// The part of a grey image above `iso` as a fog volume on the image's own lattice: true values where the
/// surface passes, tiles elsewhere, closed at the image's faces. Work follows the surface but for one look at
/// every voxel. Throws GeometryError where nothing or everything is above.
FloatGrid::Ptr shapeAbove(const Image& image, double iso);

/// The same of a label map, with the surface at 0.5: of all labels, or of one.
FloatGrid::Ptr shapeOfLabels(const Image& labels);
FloatGrid::Ptr shapeOfLabel(const Image& labels, std::int64_t label);

/// The value that parts an image's histogram best in two [Ots79].
double otsuValue(const Image& image);

/// Whether an image is a map of labels: whole numbers from 0, and next to each other mostly the same.
bool looksLikeLabels(const Image& image);

/// The labels of a map, ascending, without 0; InputError where values are no whole numbers from 0 to 2^31 or
/// over 65535 differ.
std::vector<std::int64_t> labelsOf(const Image& image);

}  // namespace slicemorph

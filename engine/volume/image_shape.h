#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// The part of a grey image above `iso` as a fog volume on the image's lattice: leaves with the image's
/// values near the surface, tiles elsewhere. It is closed at the image's faces. Every voxel is read once; the
/// rest of the work is proportional to the surface. Throws GeometryError if no or all values are above `iso`.
FloatGrid::Ptr shapeAbove(const Image& image, double iso);

/// The same for a label map, with the surface at 0.5: of all labels together, or of one.
FloatGrid::Ptr shapeOfLabels(const Image& labels);
FloatGrid::Ptr shapeOfLabel(const Image& labels, std::int64_t label);

/// The surface of such a shape at the `iso` that it was made with, 0 included, as a level set with voxels of this size,
/// world units. Throws as toLevelSet, for which 0 would be a value that is looked for.
FloatGrid::Ptr levelSetOf(const FloatGrid::ConstPtr& shape, double iso, double voxelSize);

/// The threshold that best separates the histogram into two classes [Ots79].
double otsuValue(const Image& image);

/// Whether an image seems to be a label map: non-negative integers, where neighbours are mostly equal.
bool looksLikeLabels(const Image& image);

/// The labels of a map, ascending, without 0. Throws InputError for values that are not integers from 0 to
/// 2^31 - 1, and for more than 65535 labels.
std::vector<std::int64_t> labelsOf(const Image& image);

}  // namespace slicemorph

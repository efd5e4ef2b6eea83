#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// `count` values of the images' common type, or of the smallest type that holds all of theirs.
ImageValues commonValues(const std::vector<const Image*>& images, size_t count);

/// The values in the type of `like`; integers are rounded and clamped.
ImageValues valuesAs(const ImageValues& values, const ImageValues& like);

/// Writes a row of values from index `first` on; integers are rounded and clamped.
void storeRow(const std::vector<double>& row, size_t first, ImageValues& values);

}  // namespace slicemorph

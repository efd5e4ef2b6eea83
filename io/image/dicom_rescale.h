#pragma once

#include "slicemorph/image.h"

#include <vector>

namespace slicemorph {

struct Rescale {
  double slope = 1, intercept = 0;
};

/// Rescales each slice by its own, all to one type: whole numbers where all slopes and intercepts are.
void rescaleAll(std::vector<ImageValues>& slices, const std::vector<Rescale>& rescale);

}  // namespace slicemorph

#pragma once

#include "io/contours/contour_reader.h"

namespace slicemorph {

/// Reads contours in the text format CSL ("CSLC") of the cross-section reconstruction papers [BVG11],
/// [SVB23]: planes a x + b y + c z + d = 0, points, and components "COUNT LABEL INDEX..."; COUNT is written
/// "NhP" for a hole in component P. Throws as readContours.
ContourFile readCsl(const std::string& path);

}  // namespace slicemorph

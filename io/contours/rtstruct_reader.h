#pragma once

#include "io/contours/contour_reader.h"

namespace slicemorph {

bool isRtStructureSet(const std::string& path);

/// A DICOM RT structure set (PS3.3 A.19, C.8.8.5, C.8.8.6): one set a region of interest, its closed planar
/// contours grouped by plane. Throws as readContours.
ContourFile readRtStructureSet(const std::string& path);

}  // namespace slicemorph

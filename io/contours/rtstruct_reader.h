#pragma once

#include "io/contours/contour_reader.h"

namespace slicemorph {

/// Whether a file's first bytes name the storage class of RT structure sets, or
/// a folder holds one such file and nothing else; false where there is no such
/// file.
bool isRtStructureSet(const std::string& path);

/// Reads a DICOM RT structure set (PS3.3 A.19, C.8.8.5, C.8.8.6): one set per
/// region of interest, its closed planar contours grouped by plane. `path`: the
/// file, or its folder. A region whose contours cannot be used is left to
/// `refused`. Throws as readContours.
ContourFile readRtStructureSet(const std::string& path);

}  // namespace slicemorph

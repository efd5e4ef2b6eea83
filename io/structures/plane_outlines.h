#pragma once

#include "slicemorph/io/structure_file.h"

namespace slicemorph {

/// The closed outlines on a plane of what is negative, by marching squares; between an inner and an outer pixel
/// at the border of the picture they run half way. A hole is joined to the outline around it by a cut of no width
/// (DICOM PS3.3 C.8.8.6.3, "keyhole"), so that each outline encloses its area without the holes for every reader.
std::vector<std::vector<Vec3d>> outlinesOn(const ImagePlane& plane, const std::vector<float>& values);

}  // namespace slicemorph

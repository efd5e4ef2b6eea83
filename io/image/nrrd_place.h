#pragma once

#include "io/image/nrrd_header.h"
#include "io/image/nrrd_text.h"

#include <NrrdIO.h>  // has no guard: it is included here alone

namespace slicemorph {

/// Sets lattice and axes of an image from what its header says of space, spacings and units, in LPS millimetres, with
/// notes of what it leaves open. Throws IoError where that is no image in space.
void placeNrrd(const std::string& path, const NrrdText& text, const Nrrd& nrrd, NrrdHeader& header);

}  // namespace slicemorph

#pragma once

#include "slicemorph/io/structure_file.h"

namespace slicemorph {

/// Writes a segmentation as 3D Slicer does (`.seg.nrrd`): a label map, of several layers where structures overlap, with
/// name, colour, label, layer and extent of each segment. As writeStructures.
Notes writeSegNrrd(const std::string& path, const StructureSet& set);

}  // namespace slicemorph

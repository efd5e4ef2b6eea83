#pragma once

#include "engine/measure/label_comparison.h"
#include "slicemorph/io/memory.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// Two label maps label by label.
struct MapComparison {
  std::vector<LabelComparison> labels;
  Notes notes;
};

/// Compares label maps on the first one's voxels, extended as far as the second one reaches; a second map on other
/// voxels is put on these first (the nearest voxel's label), but its volumes and centroids are its own. `name`: of both,
/// for messages. Throws MemoryError, and InputError where the voxels' axes are not at right angles.
MapComparison compareMaps(const Image& a, const Image& b, const MemoryLimit& memory, const std::string& name);

}  // namespace slicemorph

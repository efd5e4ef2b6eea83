#pragma once

#include "slicemorph/io/vdb_reader.h"

#include <openvdb/openvdb.h>

namespace slicemorph {

/// The box of a grid's active voxels, from the statistics in its file if it has some. `header`: what
/// `file.readHeader(index)` gave. Throws IoError.
openvdb::CoordBBox activeBoxIn(const VdbFile& file, size_t index, const openvdb::GridBase& header);

}  // namespace slicemorph

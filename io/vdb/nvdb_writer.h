#pragma once

#include "slicemorph/io/output.h"

namespace slicemorph {

/// Writes grids, in their order, into a NanoVDB file (not compressed, with statistics and a checksum): values, names,
/// classes and transforms. NanoVDB has no place for metadata, half floats or kinds of vectors. The same grids give the same
/// bytes; the file appears whole or not at all. Throws InputError for a grid whose type or transform NanoVDB cannot
/// hold, and IoError.
void writeNvdb(const std::string& path, const openvdb::GridCPtrVec& grids, const VdbOutput& options);

}  // namespace slicemorph

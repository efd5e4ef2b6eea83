#pragma once

#include "slicemorph/io/output.h"

#include <string>

namespace slicemorph {

/// Writes grids, in their order, into a VDB file that OpenVDB 7 and later read, each with its metadata,
/// class, half flag and the statistics of its values. The same grids and options give the same bytes:
/// OpenVDB's random file identifier is replaced by one made from the content. The grids passed in keep their
/// own metadata. Whole or not at all; throws IoError.
void writeVdb(const std::string& path, const openvdb::GridCPtrVec& grids, const VdbOutput& options);

}  // namespace slicemorph

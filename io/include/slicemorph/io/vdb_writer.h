#pragma once

#include "slicemorph/io/output.h"

#include <string>

namespace slicemorph {

/// Writes grids, in their order, into a VDB file that OpenVDB 7 and later can read, each with its metadata,
/// class, half flag and statistics. Metadata of grids and of the file that tell of an input's boxes, statistics and
/// regions of interest are left out. The same grids and options give the same bytes: OpenVDB's random file
/// identifier is replaced by a hash of the content. The grids passed in are not changed. The file appears
/// whole or not at all. Throws IoError.
void writeVdb(const std::string& path, const openvdb::GridCPtrVec& grids, const VdbOutput& options);

/// Whether a path is of a format that holds grids, by its extension: `.vdb`, `.nvdb`.
bool isGridOutput(const std::string& path);

/// Writes grids by extension, `.nvdb` without metadata. As writeVdb; throws InputError, too, for a grid that the format
/// cannot hold.
void writeGridFile(const std::string& path, const openvdb::GridCPtrVec& grids, const VdbOutput& options);

}  // namespace slicemorph

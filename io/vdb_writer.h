#pragma once

#include "io/output.h"

#include <string>

namespace slicemorph {

/// Writes a level set as the grid `surface` of a VDB file that OpenVDB 7 and later read. The same grid and options give
/// the same bytes: OpenVDB's random file identifier is replaced by one made from the content. The grid passed in keeps
/// its own name and metadata. Whole or not at all; throws IoError.
void writeVdb(const std::string& path, const FloatGrid& levelSet, const SurfaceOutput& options);

}  // namespace slicemorph

#pragma once

#include <string>

namespace slicemorph {

/// Throws IoError where the header of an EXR file claims more pixels, rows or tiles than a file of its size can hold.
/// OpenEXR takes the memory for all of them before it looks for the first. Headers that are wrong otherwise are left
/// for OpenEXR to tell.
void checkExrHeader(const std::string& path);

}  // namespace slicemorph

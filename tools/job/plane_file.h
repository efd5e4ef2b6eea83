#pragma once

#include "engine/sections/place_sections.h"

#include <string>

namespace slicemorph {

/// Parses `OX,OY,OZ/NX,NY,NZ`, a point of a plane and its normal. Throws InputError naming the option.
PlaneInSpace parsePlane(const std::string& option, const std::string& text);

/// Reads one plane per line, `ox oy oz nx ny nz`, separated by spaces, commas or semicolons; a heading, empty
/// lines and what follows a # are ignored. Throws IoError, and InputError naming file and line.
std::vector<PlaneInSpace> readPlanes(const std::string& path);

}  // namespace slicemorph

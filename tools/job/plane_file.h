#pragma once

#include "engine/sections/place_sections.h"

#include <string>

namespace slicemorph {

/// `OX,OY,OZ/NX,NY,NZ`: a point of a plane and its normal. Throws InputError naming the option.
PlaneInSpace parsePlane(const std::string& option, const std::string& text);

/// A plane a line, `ox oy oz nx ny nz`, with spaces, commas or semicolons between; a heading, empty lines and
/// what follows a # are passed over. Throws IoError, and InputError naming file and line.
std::vector<PlaneInSpace> readPlanes(const std::string& path);

}  // namespace slicemorph

#pragma once

#include "engine/pipeline.h"

#include <string>

namespace slicemorph {

/// What was decided about a plan's shapes (how they are laid, their map, notes) as bytes, without the shapes themselves,
/// which are only named by a checksum. Numbers are stored exactly, so that frames come out the same. Not compressed.
std::string bytesOfDecisions(const Plan& plan);

/// A plan whose shapes are measured, completed by those bytes. It has no contours and cannot be followed by the plan of a
/// sequence's next frame. Throws InputError for bytes that are none, are damaged, or are of other shapes.
Plan withDecisions(Plan plan, const std::string& bytes);

}  // namespace slicemorph

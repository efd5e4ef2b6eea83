#pragma once

#include "slicemorph/note.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// Millimetres of a unit of length as files name it: "mm", "um", "micron", "cm" ...; an empty one is a millimetre.
/// Nothing for what is no known unit.
std::optional<double> millimetresOf(const std::string& unit);

/// Tells which units were converted, and which are not known and were taken as millimetres.
void noteUnits(const std::vector<std::string>& units, Notes& notes);

}  // namespace slicemorph

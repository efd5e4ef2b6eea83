#pragma once

#include "slicemorph/io/input.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// Why the inputs of a job are taken to stand in one world, as part of a sentence: all are grids of simulations, that
/// is fog, or level sets named as liquids are, or files of one folder that differ in their number alone. None: they
/// may be anywhere. `names`: the inputs as they were typed.
std::optional<std::string> whyOneWorld(const std::vector<LoadedObject>& inputs,
                                       const std::vector<std::string>& names);

/// The note on it.
Note oneWorldNote(const std::string& why);

}  // namespace slicemorph

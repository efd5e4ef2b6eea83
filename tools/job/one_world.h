#pragma once

#include "slicemorph/io/input.h"
#include "slicemorph/slicemorph.h"

#include <string>
#include <vector>

namespace slicemorph {

/// A plan's options and what is told of them.
struct PlanOptions {
  MorphOptions options;
  Notes notes;
};

/// The options of a job that does not say how its inputs are aligned: those that stand in one world keep their
/// directions. Such are grids of simulations, that is fog, or level sets named as liquids are, or files of one folder
/// that differ in their number alone. `names`: the inputs as they were typed.
PlanOptions optionsInOneWorld(const MorphOptions& options, const std::vector<LoadedObject>& inputs,
                              const std::vector<std::string>& names);

}  // namespace slicemorph

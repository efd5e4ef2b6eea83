#pragma once

#include "slicemorph/guidance.h"
#include "tools/job/key_times.h"
#include "tools/job/option_set.h"

#include <map>
#include <string>
#include <vector>

namespace slicemorph {

/// What goes into a job file beside the options as they were given.
struct JobTables {
  std::vector<std::string> inputs;
  std::vector<WeightKey> keys;  ///< empty: none were given
  std::vector<Feature> features;
  std::vector<Region> regions;
  std::map<std::string, std::string> values;  ///< by key, as TOML, in place of what was given
};

/// A whole job file: every option with its help, those that were not given as comments, then features and
/// regions. Read back it says the same. Throws InputError where a text is not UTF-8, which TOML asks for.
std::string jobText(const OptionSet& options, const JobTables& tables);

/// Numbers as TOML has them, `[1, 0.5]`.
std::string tomlOf(const std::vector<double>& numbers);

}  // namespace slicemorph

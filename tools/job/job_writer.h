#pragma once

#include "slicemorph/guidance.h"
#include "tools/job/key_times.h"
#include "tools/job/option_set.h"

#include <map>
#include <string>
#include <vector>

namespace slicemorph {

/// What goes into a job file in addition to the options as they were given.
struct JobTables {
  std::vector<std::string> inputs;
  std::vector<WeightKey> keys;  ///< empty: none were given
  std::vector<Feature> features;
  std::vector<Region> regions;
  std::map<std::string, std::string> values;  ///< by key, as TOML, instead of what was given
};

/// A whole job file: every option with its help, those that were not given as comments, then features
/// and regions. Reading it back gives the same job. Throws InputError where a text is not UTF-8,
/// which TOML requires.
std::string jobText(const OptionSet& options, const JobTables& tables);

/// The same of what was given alone, without comments.
std::string givenJobText(const OptionSet& options, const JobTables& tables);

/// A TOML list of numbers, `[1, 0.5]`.
std::string tomlOf(const std::vector<double>& numbers);
/// A TOML list of landmarks, `[[[0, 0, 0], [1, 0, 0]]]`.
std::string tomlOf(const std::vector<std::vector<Vec3d>>& landmarks);

}  // namespace slicemorph

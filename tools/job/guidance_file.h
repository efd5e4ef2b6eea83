#pragma once

#include "slicemorph/guidance.h"
#include "slicemorph/note.h"
#include "tools/job/job_file.h"
#include "tools/job/key_times.h"

#include <string>
#include <vector>

/// Reads the parts of a job file that are not plain `key = value` lines: keys over time, features, regions.
/// Inputs are named as inputNamed() knows them. Everything throws IoError where the file cannot be read and
/// InputError `file:line:column: ...`.
namespace slicemorph {

struct Guidance {
  std::vector<Feature> features;  ///< of tables [[feature]]
  std::vector<Region> regions;    ///< of tables [[region]]
  Notes notes;
};
Guidance readGuidance(const JobFile& file, const std::vector<std::string>& inputs);

struct KeyList {
  std::vector<WeightKey> keys;  ///< empty: the file has none
  Notes notes;
};
/// `keys = "a@0 b@1"` or a list of tables {at = 0, input = "a"} or {at = 0, weights = [...]}.
KeyList readKeys(const JobFile& file, const std::vector<std::string>& inputs);

}  // namespace slicemorph

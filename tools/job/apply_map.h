#pragma once

#include "slicemorph/io/input.h"
#include "slicemorph/slicemorph.h"
#include "tools/job/job_events.h"
#include "tools/job/option_set.h"

#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph apply` is to do; values are checked.
struct ApplyJob {
  std::vector<std::string> inputs;  ///< objects, in the order of time
  std::string what;                 ///< points or an image; empty: the map itself is written
  std::string output;
  double from = 0, to = 1;  ///< times, 0 to 1
  std::string like;         ///< image whose voxels an image or field gets; empty: none
  LoadOptions load;
  std::string planFile;  ///< by which the objects are matched; empty: they are matched anew
  MorphOptions plan;
  bool alignGiven = false;

  bool field() const { return what.empty(); }
};

/// Checks the options of `apply` and that its files are there. Throws InputError, IoError.
ApplyJob applyJob(const OptionSet& options);

/// Plans the morph and carries points, an image or nothing but the map's own displacements from the one time to the
/// other. Throws InputError, IoError, GeometryError, Cancelled.
void applyMap(const ApplyJob& job, JobEvents& events);

}  // namespace slicemorph

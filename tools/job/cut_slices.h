#pragma once

#include "slicemorph/io/input.h"
#include "tools/job/job_events.h"
#include "tools/job/slice_options.h"

#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph slice` is to do; values are checked.
struct CutJob {
  std::string input;
  std::string output;              ///< one .exr, or one per slice where it has ####
  std::vector<std::string> grids;  ///< empty: all
  SliceOptions slices;
  LoadOptions load;
};

/// Writes oriented slices of a volume's grids as EXR images. Throws InputError,
/// IoError, GeometryError, Cancelled.
void cutSlices(const CutJob& job, JobEvents& events);

}  // namespace slicemorph

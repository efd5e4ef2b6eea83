#pragma once

#include "slicemorph/io/input.h"
#include "tools/job/job_events.h"
#include "tools/job/slice_options.h"

#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph slice` is to do, checked.
struct CutJob {
  std::string input;
  std::string output;              ///< one .exr, or one a slice where it has ####
  std::vector<std::string> grids;  ///< none: all
  SliceOptions slices;
  LoadOptions load;
};

/// Oriented slices of any volume, all its grids, as EXR images. Throws InputError, IoError, GeometryError,
/// Cancelled.
void cutSlices(const CutJob& job, JobEvents& events);

}  // namespace slicemorph

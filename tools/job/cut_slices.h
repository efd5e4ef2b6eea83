#pragma once

#include "io/input_grids.h"
#include "tools/job/job_events.h"
#include "tools/job/option_set.h"
#include "tools/job/slice_options.h"

#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph slice` is to do; values are checked.
struct CutJob {
  std::string input;
  std::shared_ptr<const HeldInput> held;  ///< the input where it is in memory
  std::string output;                     ///< one .exr, or one per slice where it has ####
  std::vector<std::string> grids;         ///< empty: all
  SliceOptions slices;
  LoadOptions load;
};

/// Checks the options of `slice`, but not whether files are there. Throws InputError.
CutJob cutJob(const OptionSet& options);

/// What is cut, and where.
struct CutVolume {
  InputGrids input;
  std::vector<SectionPlane> planes;
};
/// Reads the input and places the slices. Throws as cutSlices.
CutVolume volumeToCut(const CutJob& job, JobEvents& events);

/// Writes oriented slices of a volume's grids as EXR images. Throws InputError,
/// IoError, GeometryError, Cancelled.
void cutSlices(const CutJob& job, JobEvents& events);

}  // namespace slicemorph

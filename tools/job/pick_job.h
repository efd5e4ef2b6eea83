#pragma once

#include "tools/job/job_events.h"
#include "tools/job/morph_job.h"

#include <string>

namespace slicemorph {

/// What `slicemorph pick` is to do; values are checked.
struct PickJob {
  MorphJob morph;      ///< the morph whose features are picked
  std::string output;  ///< the page
  bool plan = true;    ///< the inputs are matched, to show what meets what
};

/// Reads the options of `pick` and the job file that they name, and checks that the inputs are there. Options and tables of
/// the job file that are not about matching go on into the page's job file, but for those of one run, as its output. Throws
/// InputError, IoError.
PickJob pickJob(const OptionSet& options);

/// Reads the inputs, plans the morph and writes the page. Throws as runMorph.
void runPick(const PickJob& job, JobEvents& events);

/// The part of a page that shows the inputs of a morph as they are planned, see pickPart(). `plan`: null: they are shown
/// without a match. `file`: name of the job file that the page makes. Throws Cancelled.
std::string pickPartOf(const MorphSettings& settings, const std::vector<LoadedObject>& inputs,
                       const MorphPlan* plan, const std::string& file, const Notes& notes,
                       const Progress& cancel);

}  // namespace slicemorph

#pragma once

#include "slicemorph/note.h"
#include "tools/job/job_writer.h"
#include "tools/job/morph_settings.h"
#include "tools/job/option_set.h"

namespace slicemorph {

/// What `slicemorph morph` is to do, from its options.
struct MorphJob {
  MorphSettings settings;
  JobTables tables;  ///< for jobText()
  Notes notes;       ///< of what was taken otherwise than it was said
};

/// Reads what the options and their job file say, and checks it as far as that can be done without the inputs'
/// contents; only the lengths of sequences, files of landmarks and of planes are looked up, and none of them
/// where --print-config is among the options. Throws InputError, IoError.
MorphJob morphJob(const OptionSet& options);

}  // namespace slicemorph

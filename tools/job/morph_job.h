#pragma once

#include "slicemorph/note.h"
#include "tools/job/job_writer.h"
#include "tools/job/morph_settings.h"
#include "tools/job/option_set.h"

namespace slicemorph {

/// What `slicemorph morph` is to do.
struct MorphJob {
  MorphSettings settings;
  JobTables tables;  ///< for jobText()
  Notes notes;       ///< on values that were changed or have no effect
};

/// Reads the options and their job file, and checks them as far as possible without the inputs' contents. Of
/// other files only the lengths of sequences, landmarks and planes are read, and none of these with
/// --print-config. Throws InputError, IoError.
MorphJob morphJob(const OptionSet& options);

}  // namespace slicemorph

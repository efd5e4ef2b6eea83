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

/// Times of so many frames, evenly from 0 to 1; of one, 0.
std::vector<double> evenTimes(int frames);
/// The frames of a sequence at these times, numbered from `start`, 1 / fps seconds apart whatever their times.
std::vector<FrameJob> framesAt(const MorphSettings& settings, const std::vector<double>& times, int start);
/// Change of the weights per second at a time of a sequence in which a frame takes `perFrame` of the time.
Weights rateAt(const MorphSettings& settings, double t, double perFrame);

}  // namespace slicemorph

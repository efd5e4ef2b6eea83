#pragma once

#include "tools/job/morph_settings.h"
#include "tools/job/option_set.h"

namespace slicemorph {

/// What `slicemorph retime` is to do.
struct RetimeJob {
  /// Of every two neighbouring files a morph: its inputs are the sequence without its last file and without its first
  /// one, a frame's `inputFrame` is the pair. Frames that show a file itself name it.
  MorphSettings settings;
  std::vector<int> numbers;  ///< of the files
};

/// Reads the options and checks them as far as possible without the files' contents. Throws InputError, IoError.
RetimeJob retimeJob(const OptionSet& options);

}  // namespace slicemorph

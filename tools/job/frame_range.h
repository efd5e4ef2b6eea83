#pragma once

#include "tools/job/morph_settings.h"
#include "tools/job/option_set.h"

namespace slicemorph {

/// Leaves the frames that --range does not ask for to others. With --print-config the frames of sequences are not known.
/// Throws InputError for numbers that no frame has.
void keepRange(std::vector<FrameJob>& frames, const OptionSet& options);

}  // namespace slicemorph

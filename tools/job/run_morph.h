#pragma once

#include "tools/job/job_events.h"
#include "tools/job/morph_settings.h"

namespace slicemorph {

/// Does what `slicemorph morph` does, once its settings are checked: reads the inputs, plans, and makes,
/// measures and writes the frames one after another, then the reports. Throws InputError, IoError,
/// GeometryError and Cancelled; what is done of a sequence can be gone on with by `settings.resume`.
void runMorph(const MorphSettings& settings, JobEvents& events);

}  // namespace slicemorph

#pragma once

#include "tools/job/job_events.h"
#include "tools/job/morph_settings.h"

namespace slicemorph {

/// Runs `slicemorph morph` with checked settings: reads the inputs, plans, makes, measures and writes the
/// frames one after another, then writes the reports. Throws InputError, IoError, GeometryError and
/// Cancelled; an interrupted sequence can be continued with `settings.resume`.
void runMorph(const MorphSettings& settings, JobEvents& events);

}  // namespace slicemorph

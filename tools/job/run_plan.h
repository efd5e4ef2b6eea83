#pragma once

#include "tools/job/job_events.h"
#include "tools/job/morph_settings.h"
#include "tools/job/plan_file.h"

namespace slicemorph {

/// Plans a morph and writes the plan: of inputs that are sequences one a frame, `output` then has a #### for its number.
/// `like`: its options. Throws InputError where the name does not fit, and as runMorph.
void runPlan(const MorphSettings& settings, PlanFile like, const std::string& output, JobEvents& events);

}  // namespace slicemorph

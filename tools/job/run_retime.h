#pragma once

#include "tools/job/job_events.h"
#include "tools/job/retime_job.h"

namespace slicemorph {

/// Runs `slicemorph retime`: frames that show a file are that file, those between two files are made by the plan of
/// these and the neighbouring ones. Three plans are held at most, whatever the length of the sequence. Throws as
/// runMorph.
void runRetime(const RetimeJob& job, JobEvents& events);

}  // namespace slicemorph

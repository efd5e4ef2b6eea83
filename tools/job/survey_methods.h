#pragma once

#include "io/scratch_folder.h"
#include "tools/job/survey_job.h"
#include "tools/report/survey_result.h"

#include <vector>

namespace slicemorph {

/// What one method made.
struct MethodRun {
  SurveyMethod method;  ///< without distances, picture and score
  std::string files;    ///< of its frames, a name with ####
};

/// Runs every method of a survey in a process of its own, one after another; their files go into the scratch folder.
/// Throws IoError where the program cannot be started; Cancelled.
std::vector<MethodRun> runMethods(const SurveyJob& job, const ScratchFolder& scratch, Progress& progress);

}  // namespace slicemorph

#pragma once

#include "tools/job/job_events.h"
#include "tools/job/morph_job.h"

#include <string>
#include <utility>
#include <vector>

namespace slicemorph {

/// Without an option: few enough frames and voxels to run all methods within minutes.
constexpr int kSurveyFrames = 9, kSurveyResolution = 64;

/// A shape that the morph should have at a time.
struct SurveyTruth {
  double t = 0.5;
  size_t frame = 0;  ///< at that time, from 0
  std::string file;
};

/// What `slicemorph survey` is to do; values are checked.
struct SurveyJob {
  MorphJob morph;  ///< by the default method
  /// A method, and how it was asked for.
  struct Asked {
    std::string text;
    const MorphMethod* method;
  };
  std::vector<Asked> methods;
  std::vector<SurveyTruth> truths;
  std::string page, table;  ///< .html and .csv; the latter empty: none
  /// An option of `morph` with its values.
  struct Given {
    const OptionRow* row;
    std::vector<std::string> texts;
  };
  std::vector<Given> given;  ///< for every method that can take them, beside inputs, features and regions
};

/// Reads the options of `survey` and the job file that they name, and checks that the inputs are there and the outputs can be
/// written. Of the job file only what `survey` has as options counts, and features and regions; a note names the rest.
/// Throws InputError, IoError.
SurveyJob surveyJob(const OptionSet& options);

/// Runs every method in a process of its own, one after another, measures what they made, and writes page and table, both
/// or none. A method that fails is told on the page. Throws IoError, InputError, GeometryError of the inputs, Cancelled.
void runSurvey(const SurveyJob& job, JobEvents& events);

}  // namespace slicemorph

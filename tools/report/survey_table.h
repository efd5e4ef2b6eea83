#pragma once

#include "tools/report/survey_result.h"

namespace slicemorph {

/// The figures as CSV: a line a frame of each method, and one for a method that has none.
std::string surveyTable(const SurveyResult& survey);

}  // namespace slicemorph

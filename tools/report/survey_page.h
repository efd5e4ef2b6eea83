#pragma once

#include "tools/report/survey_result.h"

namespace slicemorph {

/// The page of a survey: one HTML file without a script, which needs no network: the score of every method, its contact
/// sheet, curves of all of them, and what the others say.
std::string surveyPage(const SurveyResult& survey);

}  // namespace slicemorph

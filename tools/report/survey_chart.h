#pragma once

#include "tools/report/survey_result.h"

namespace slicemorph {

/// Colour of the n-th method, and whether and how its line is dashed, as SVG attributes have them.
struct SurveyStroke {
  std::string colour, dashes;  ///< dashes: empty: a solid line
};
SurveyStroke strokeOf(size_t method);

/// Curves of volume, area, pieces, genus and change over time, of all methods in one picture: an SVG whose lines have the
/// classes `line kN` of the N-th method.
std::string surveyChart(const SurveyResult& survey);

}  // namespace slicemorph

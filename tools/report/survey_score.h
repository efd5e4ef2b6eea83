#pragma once

#include "tools/report/survey_result.h"

namespace slicemorph {

/// Points for what goes wrong, so that one point is about as visible as another. Chosen by hand, stated on the page.
struct SurveyPrices {
  double ends = 10;   ///< a mean distance of the ends from the inputs of 1 % of their diagonal
  double parts = 10;  ///< a piece or handle too many or too few, in the mean of the frames
  double size = 1;    ///< a cube root of the volume that is 1 % off the line between the inputs, in the mean
  double area = 1;    ///< the same of the square root of the area
  double change = 0.1;  ///< steps from frame to frame that differ from the mean step by 1 %, in the mean
};

/// Scores a method with frames. With true frames the score is the mean distance to these, in percent of their diagonal, and
/// nothing else. `unranked` is set where there is nothing to score.
void scoreMethod(SurveyMethod& method, const std::vector<SurveyShape>& inputs,
                 const std::vector<SurveyShape>& truths);

/// Puts the methods in the order of SurveyResult::methods; equal ones stay as they are.
void sortByScore(std::vector<SurveyMethod>& methods);

/// What the score is, in sentences. `truths`: their number.
std::string scoreInWords(size_t truths);

}  // namespace slicemorph

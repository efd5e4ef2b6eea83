#include "tools/report/survey_score.h"

#include "tools/report/page_text.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

double ofLine(const SurveyFrame& frame, const std::vector<SurveyShape>& inputs,
              double (*size)(const ShapeMeasures&)) {
  double expected = 0;
  for (size_t k = 0; k < inputs.size(); ++k) expected += frame.weights[k] * size(inputs[k].shape);
  return 100 * std::abs(size(frame.shape) / expected - 1);
}

/// By how much a count is outside the range of the inputs' counts.
double outside(int count, const std::vector<SurveyShape>& inputs, int ShapeMeasures::*which) {
  int least = inputs[0].shape.*which, most = least;
  for (const SurveyShape& input : inputs)
    least = std::min(least, input.shape.*which), most = std::max(most, input.shape.*which);
  return std::max({0, count - most, least - count});
}

double meanOf(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / double(values.size());
}

/// Mean deviation of the steps from their mean, percent of that.
double unevenness(const std::vector<SurveyFrame>& frames) {
  std::vector<double> steps, off;
  for (const SurveyFrame& frame : frames)
    if (frame.change) steps.push_back(*frame.change);
  const double mean = meanOf(steps);
  for (const double step : steps) off.push_back(mean > 0 ? 100 * std::abs(step / mean - 1) : 0);
  return meanOf(off);
}

SurveyScore penalties(const SurveyMethod& method, const std::vector<SurveyShape>& inputs) {
  const SurveyPrices price;
  std::vector<double> parts, size, area;
  for (const SurveyFrame& frame : method.frames) {
    parts.push_back(outside(frame.shape.pieces, inputs, &ShapeMeasures::pieces) +
                    outside(frame.shape.genus, inputs, &ShapeMeasures::genus));
    size.push_back(ofLine(frame, inputs, [](const ShapeMeasures& s) { return std::cbrt(s.volume); }));
    area.push_back(ofLine(frame, inputs, [](const ShapeMeasures& s) { return std::sqrt(s.area); }));
  }
  SurveyScore score;
  score.ends = price.ends *
               meanOf({method.frames.front().distance->percent(), method.frames.back().distance->percent()});
  score.parts = price.parts * meanOf(parts);
  score.size = price.size * meanOf(size), score.area = price.area * meanOf(area);
  score.change = price.change * unevenness(method.frames);
  return score;
}

/// The frames that have a truth, or the ends where there is none.
std::vector<const SurveyFrame*> comparedFrames(const SurveyMethod& method,
                                               const std::vector<SurveyShape>& truths) {
  std::vector<const SurveyFrame*> compared;
  if (truths.empty()) compared = {&method.frames.front(), &method.frames.back()};
  for (const SurveyShape& truth : truths) {
    const auto nearest = std::min_element(method.frames.begin(), method.frames.end(),
                                          [&](const SurveyFrame& a, const SurveyFrame& b) {
                                            return std::abs(a.t - truth.t) < std::abs(b.t - truth.t);
                                          });
    compared.push_back(&*nearest);
  }
  return compared;
}

}  // namespace

void scoreMethod(SurveyMethod& method, const std::vector<SurveyShape>& inputs,
                 const std::vector<SurveyShape>& truths) {
  if (method.frames.empty() || !method.unranked.empty()) return;
  const std::vector<const SurveyFrame*> compared = comparedFrames(method, truths);
  for (const SurveyFrame* frame : compared)
    if (!frame->distance) {
      method.unranked = "there is no surface at t=" + shownNumber(frame->t);
      return;
    }
  if (truths.empty()) {
    method.score = penalties(method, inputs);
    return;
  }
  std::vector<double> distances;
  for (const SurveyFrame* frame : compared) distances.push_back(frame->distance->percent());
  method.score = SurveyScore();
  method.score->truth = meanOf(distances);
}

void sortByScore(std::vector<SurveyMethod>& methods) {
  const auto place = [](const SurveyMethod& m) { return m.score ? 0 : m.refusal.empty() ? 1 : 2; };
  std::stable_sort(methods.begin(), methods.end(), [&](const SurveyMethod& a, const SurveyMethod& b) {
    if (place(a) != place(b)) return place(a) < place(b);
    return a.score && a.score->points() < b.score->points();
  });
}

std::string scoreInWords(size_t truths) {
  if (truths > 0)
    return std::string("The score is the mean distance between the surface and ") +
           (truths == 1 ? "the true one" : "the true ones") +
           ", measured from both sides, in percent of the diagonal of the box around the true shape. The "
           "fewer the "
           "better.";
  const SurveyPrices price;
  return "The score adds up what is not as one would expect of a plain morph; the fewer points the better. " +
         shownNumber(price.ends) +
         " points for each percent (of the diagonal of the box around an input) that the first and last "
         "frame lie "
         "away from their inputs, in the mean; " +
         shownNumber(price.parts) +
         " for each piece or handle more than the inputs have, or fewer, in the mean of all frames; " +
         shownNumber(price.size) + " for each percent by which the size (the cube root of the volume) and " +
         shownNumber(price.area) +
         " for each by which the square root of the area is off the straight line between the inputs', in "
         "the "
         "mean; " +
         shownNumber(price.change) +
         " for each percent by which the steps from frame to frame differ from the mean step. The prices are "
         "chosen by "
         "hand; a morph that is meant to do otherwise, as to fall into pieces, pays for that all the same.";
}

}  // namespace slicemorph

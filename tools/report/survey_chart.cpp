#include "tools/report/survey_chart.h"

#include "tools/report/page_text.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

namespace slicemorph {
namespace {

/// Pixels: a panel, the part of it that its axes take, and the gap between lines of whole numbers that are equal.
constexpr double kPanelWidth = 376, kPanelHeight = 262, kLeft = 46, kTop = 34, kRight = 14, kBottom = 34,
                 kApart = 1.8;
constexpr size_t kColumns = 3;
/// Most of an axis, in largest values of the inputs: what is beyond leaves the panel, and the others can be told apart.
constexpr double kMostOfInputs = 2.5;
/// Most pieces or handles on an axis, beyond the inputs'.
constexpr double kMostBeyond = 8;

constexpr const char* kDashes[] = {"", "7 3", "2 3", "9 3 2 3"};

using Points = std::vector<std::pair<double, double>>;  ///< time and value

/// One of the picture's panels.
struct Panel {
  std::string title;
  bool counts = false;             ///< whole numbers
  double most = 0;                 ///< of the axis; 0: the largest value
  Points expected = {};            ///< a grey line; empty: none
  std::vector<Points> lines = {};  ///< one a method
};

Points pointsOf(const SurveyMethod& method,
                const std::function<std::optional<double>(const SurveyFrame&)>& value) {
  Points points;
  if (method.surface)
    for (const SurveyFrame& frame : method.frames)
      if (const std::optional<double> v = value(frame)) points.emplace_back(frame.t, *v);
  return points;
}

/// What the inputs' sizes become where a length goes straight from one to the other. `power`: of the length.
Points straight(const SurveyResult& survey, double ShapeMeasures::*size, double power) {
  Points points;
  const auto first = std::find_if(survey.methods.begin(), survey.methods.end(),
                                  [](const SurveyMethod& m) { return !m.frames.empty(); });
  if (first == survey.methods.end()) return points;
  for (const SurveyFrame& frame : first->frames) {
    double length = 0;
    for (size_t k = 0; k < survey.inputs.size(); ++k)
      length += frame.weights[k] * std::pow(survey.inputs[k].shape.*size, 1 / power);
    points.emplace_back(frame.t, std::pow(length, power));
  }
  return points;
}

template <typename Number>
double mostOfInputs(const SurveyResult& survey, Number ShapeMeasures::*which) {
  double most = 0;
  for (const SurveyShape& input : survey.inputs) most = std::max(most, double(input.shape.*which));
  return most;
}

double topOf(const Panel& panel) {
  double top = panel.counts ? 1 : 0;
  for (const auto& [t, value] : panel.expected) top = std::max(top, value);
  for (const Points& line : panel.lines)
    for (const auto& [t, value] : line) top = std::max(top, value);
  if (panel.most > 0) top = std::min(top, panel.most);
  return top > 0 ? top : 1;
}

/// A step of 1, 2 or 5 times a power of ten that parts the axis into four to eight.
double tickOf(double top, bool counts) {
  const double power = std::pow(10, std::floor(std::log10(top / 4)));
  const double ratio = top / 4 / power;
  const double tick = power * (ratio >= 5 ? 5 : ratio >= 2 ? 2 : 1);
  return counts ? std::max(1.0, tick) : tick;
}

std::string pixel(double value) { return shownNumber(std::round(value * 100) / 100, 7); }

std::string label(double x, double y, const std::string& kind, const std::string& text) {
  return "<text x=\"" + pixel(x) + "\" y=\"" + pixel(y) + "\" class=\"" + kind + "\">" +
         escapedForPage(text) + "</text>\n";
}

std::string polyline(const std::string& attributes, const std::string& points) {
  return points.empty() ? "" : "<polyline " + attributes + " points=\"" + points + "\"/>\n";
}

std::string strokeAttributes(size_t method) {
  const SurveyStroke stroke = strokeOf(method);
  return "class=\"line k" + std::to_string(method) + "\" stroke=\"" + stroke.colour + "\"" +
         (stroke.dashes.empty() ? "" : " stroke-dasharray=\"" + stroke.dashes + "\"");
}

/// Draws a panel at its place in the picture.
std::string drawn(const Panel& panel, size_t index) {
  const double width = kPanelWidth - kLeft - kRight, height = kPanelHeight - kTop - kBottom;
  const double tick = tickOf(topOf(panel), panel.counts), top = std::ceil(topOf(panel) / tick) * tick;
  const auto across = [&](double t) { return kLeft + t * width; };
  const auto up = [&](double value) { return kTop + height * (1 - value / top); };
  std::string text = "<g transform=\"translate(" + pixel(double(index % kColumns) * kPanelWidth) + " " +
                     pixel(double(index / kColumns) * kPanelHeight) + ")\">\n";
  text += label(kLeft, kTop - 14, "title", panel.title);
  for (int i = 0; i * tick <= top * (1 + 1e-9); ++i) {
    const std::string y = pixel(up(i * tick));
    text += "<path class=\"grid\" d=\"M" + pixel(kLeft) + " " + y + "H" + pixel(kLeft + width) + "\"/>\n";
    text += label(kLeft - 6, up(i * tick) + 4, "y", shownNumber(i * tick, 4));
  }
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0})
    text += label(across(t), kTop + height + 17, "x", (t == 0 ? "t=" : "") + shownNumber(t));
  const std::string inside = "inside" + std::to_string(index);
  text += "<clipPath id=\"" + inside + "\"><rect x=\"" + pixel(kLeft - 2) + "\" y=\"" + pixel(kTop - 6) +
          "\" width=\"" + pixel(width + 4) + "\" height=\"" + pixel(height + 12) + "\"/></clipPath>\n";
  text += "<g clip-path=\"url(#" + inside + ")\">\n";
  const auto spelled = [&](const Points& points, double lower) {
    std::string all;
    for (const auto& [t, value] : points)
      all += (all.empty() ? "" : " ") + pixel(across(t)) + "," + pixel(up(value) + lower);
    return all;
  };
  text += polyline("class=\"expected\"", spelled(panel.expected, 0));
  const auto shown = double(std::count_if(panel.lines.begin(), panel.lines.end(),
                                          [](const Points& line) { return !line.empty(); }));
  double place = 0;
  // The best is drawn last, above the others.
  for (size_t i = panel.lines.size(); i-- > 0;) {
    if (panel.lines[i].empty()) continue;
    const double lower = panel.counts ? kApart * (place++ - (shown - 1) / 2) : 0;
    text += polyline(strokeAttributes(i), spelled(panel.lines[i], lower));
  }
  return text + "</g>\n</g>\n";
}

/// The names beside their lines, where the last panel would be.
std::string legend(const SurveyResult& survey, size_t index) {
  std::string text = "<g transform=\"translate(" + pixel(double(index % kColumns) * kPanelWidth) + " " +
                     pixel(double(index / kColumns) * kPanelHeight) + ")\">\n";
  double y = kTop;
  const auto row = [&](const std::string& attributes, const std::string& name, const std::string& kind) {
    text += polyline(attributes,
                     pixel(kLeft) + "," + pixel(y - 4) + " " + pixel(kLeft + 34) + "," + pixel(y - 4));
    text += label(kLeft + 44, y, kind, name);
    y += 17;
  };
  for (size_t i = 0; i < survey.methods.size(); ++i)
    if (survey.methods[i].surface && !survey.methods[i].frames.empty())
      row(strokeAttributes(i), survey.methods[i].name, "name k" + std::to_string(i));
  row("class=\"expected\"", "lengths straight between the inputs'", "name");
  return text + "</g>\n";
}

}  // namespace

SurveyStroke strokeOf(size_t method) {
  return {seriesColour(method), kDashes[method / kSeriesColours % std::size(kDashes)]};
}

std::string surveyChart(const SurveyResult& survey) {
  const auto counts = [&](const char* title, int ShapeMeasures::*which) {
    return Panel{title, true, mostOfInputs(survey, which) + kMostBeyond};
  };
  const auto sizes = [&](const char* title, double ShapeMeasures::*which, double power) {
    return Panel{title, false, kMostOfInputs * mostOfInputs(survey, which), straight(survey, which, power)};
  };
  std::vector<Panel> panels = {sizes("Volume, world units cubed", &ShapeMeasures::volume, 3),
                               sizes("Area, world units squared", &ShapeMeasures::area, 2),
                               {"Change from frame to frame, units cubed"},
                               counts("Pieces", &ShapeMeasures::pieces),
                               counts("Genus: handles of all pieces", &ShapeMeasures::genus)};
  panels[2].most = kMostOfInputs * mostOfInputs(survey, &ShapeMeasures::volume);
  const std::function<std::optional<double>(const SurveyFrame&)> values[] = {
      [](const SurveyFrame& f) { return f.shape.volume; }, [](const SurveyFrame& f) { return f.shape.area; },
      [](const SurveyFrame& f) { return f.change; }, [](const SurveyFrame& f) { return f.shape.pieces; },
      [](const SurveyFrame& f) { return f.shape.genus; }};
  size_t rows = (panels.size() + kColumns) / kColumns;
  std::string text;
  for (size_t i = 0; i < panels.size(); ++i) {
    for (const SurveyMethod& method : survey.methods) panels[i].lines.push_back(pointsOf(method, values[i]));
    text += drawn(panels[i], i);
  }
  text += legend(survey, panels.size());
  return "<svg id=\"curves\" viewBox=\"0 0 " + pixel(kColumns * kPanelWidth) + " " +
         pixel(double(rows) * kPanelHeight) + "\" role=\"img\" aria-label=\"curves over time\">\n" + text +
         "</svg>\n";
}

}  // namespace slicemorph

#include "tools/report/survey_page.h"

#include "engine/numerics/readable.h"
#include "tools/report/page_template.h"
#include "tools/report/page_text.h"
#include "tools/report/survey_chart.h"
#include "tools/report/survey_score.h"

#include <algorithm>
#include <filesystem>

namespace slicemorph {
namespace {

constexpr const char* kStyle = R"(
:root { --ink: #1d2126; --soft: #6b737d; --line: #dfe3e8; --paper: #fbfbfa; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 15px/1.45 system-ui, sans-serif; }
main { max-width: 1220px; margin: 0 auto; padding: 28px 24px 60px; }
h1 { font-size: 24px; font-weight: 600; margin: 0 0 4px; overflow-wrap: anywhere; }
h2 { font-size: 17px; font-weight: 600; margin: 40px 0 10px; }
.soft, .soft a { color: var(--soft); }
p { max-width: 88ch; margin: 8px 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { padding: 5px 13px 5px 0; text-align: right; border-bottom: 1px solid var(--line); font-weight: 400; white-space: nowrap; }
th { color: var(--soft); vertical-align: bottom; }
th:nth-child(2), td:nth-child(2), .left { text-align: left; }
td a { color: inherit; text-decoration: none; font-weight: 600; }
.swatch { display: inline-block; width: 26px; height: 10px; margin-right: 9px; vertical-align: 1px; overflow: visible; }
.bar { display: flex; width: 150px; height: 12px; }
.bar i { display: block; height: 100%; }
.ends { background: #3b4a5c; } .parts { background: #b23a00; } .size { background: #5b8fb9; } .area { background: #a9c6dd; }
.change { background: #c9b47c; } .truth { background: #3b4a5c; }
.head i { display: inline-block; width: 10px; height: 10px; margin-right: 5px; }
figure { margin: 0 0 20px; }
.times { display: grid; position: sticky; top: 0; padding: 6px 0 8px; background: var(--paper); text-align: center;
  font-size: 13px; font-variant-numeric: tabular-nums; color: var(--soft); z-index: 1; }
figcaption { display: flex; gap: 12px; align-items: baseline; margin-bottom: 5px; }
figcaption b { font-weight: 600; }
figcaption .end { margin-left: auto; white-space: nowrap; }
figure img { display: block; width: 100%; height: auto; border: 1px solid var(--line); border-radius: 6px; }
figure ul { margin: 4px 0 0; padding-left: 20px; color: var(--soft); font-size: 13px; }
#curves { display: block; width: 100%; height: auto; background: #fff; border: 1px solid var(--line); border-radius: 6px; }
#curves text { font: 12px system-ui, sans-serif; fill: var(--soft); }
#curves .title { font-size: 13px; font-weight: 600; fill: var(--ink); }
#curves .name { font-size: 13px; fill: var(--ink); }
#curves .y { text-anchor: end; } #curves .x { text-anchor: middle; }
#curves .grid { stroke: #eceff2; fill: none; }
.line { fill: none; stroke-width: 2; stroke-linejoin: round; }
#curves .expected { fill: none; stroke: #a3abb4; stroke-width: 1.5; stroke-dasharray: 1 4; stroke-linecap: round; }
dt { font-weight: 600; } dd { margin: 0 0 12px; overflow-wrap: anywhere; max-width: 100ch; }
@media print { figure, #curves { break-inside: avoid; } }
)";

/// A part of the score: its name, what it is called on the page, its value.
struct Part {
  const char *kind, *title;
  double SurveyScore::*points;
};
constexpr Part kParts[] = {{"ends", "ends", &SurveyScore::ends},
                           {"parts", "pieces,<br>handles", &SurveyScore::parts},
                           {"size", "size", &SurveyScore::size},
                           {"area", "area", &SurveyScore::area},
                           {"change", "steps", &SurveyScore::change}};

std::string stemOf(const std::string& name) {
  return std::filesystem::path(name).filename().replace_extension().string();
}

std::string htmlElement(const std::string& tag, const std::string& content,
                        const std::string& attributes = "") {
  return "<" + tag + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + tag + ">";
}

std::string tableCell(const std::string& content) { return htmlElement("td", content); }

std::string keyOf(size_t method) { return "k" + std::to_string(method); }

std::string swatch(size_t method) {
  const SurveyStroke stroke = strokeOf(method);
  return "<svg class=\"swatch\" viewBox=\"0 0 26 10\"><path d=\"M0 5H26\" stroke=\"" + stroke.colour +
         "\" stroke-width=\"3\"" +
         (stroke.dashes.empty() ? "" : " stroke-dasharray=\"" + stroke.dashes + "\"") + "/></svg>";
}

std::string listOf(const std::vector<std::string>& sentences) {
  std::string items;
  for (const std::string& sentence : sentences) items += htmlElement("li", escapedForPage(sentence));
  return items.empty() ? "" : htmlElement("ul", items);
}

/// The score as a bar of its parts. `most`: points that are as long as the bar can be.
std::string barOf(const SurveyScore& score, double most) {
  std::string parts;
  const auto add = [&](const char* kind, double points) {
    if (points > 0)
      parts += htmlElement(
          "i", "",
          std::string("class=\"") + kind + "\" style=\"width:" + shownNumber(100 * points / most, 4) + "%\"");
  };
  for (const Part& part : kParts) add(part.kind, score.*part.points);
  add("truth", score.truth);
  return htmlElement("div", parts, "class=\"bar\"");
}

const SurveyFrame* frameAt(const SurveyMethod& method, double t) {
  const auto at = std::find_if(method.frames.begin(), method.frames.end(),
                               [&](const SurveyFrame& frame) { return std::abs(frame.t - t) < 1e-6; });
  return at == method.frames.end() ? nullptr : &*at;
}

/// The range of a count over all frames: "1" or "1-4".
std::string rangeOf(const SurveyMethod& method, int ShapeMeasures::*which) {
  int least = method.frames[0].shape.*which, most = least;
  for (const SurveyFrame& frame : method.frames)
    least = std::min(least, frame.shape.*which), most = std::max(most, frame.shape.*which);
  return std::to_string(least) + (most > least ? "&ndash;" + std::to_string(most) : "");
}

/// The largest mean stretch of all frames; empty where the method has no map of surfaces.
std::string stretchOf(const SurveyMethod& method) {
  double most = 0;
  for (const SurveyFrame& frame : method.frames) most = std::max(most, frame.meanStretch.value_or(0));
  return most > 0 ? shownNumber(most, 3) : "";
}

std::string headOf(const SurveyResult& survey) {
  std::string cells = htmlElement("th", "") + htmlElement("th", "method");
  const auto add = [&](const std::string& title) { cells += htmlElement("th", title); };
  add(survey.truths.empty() ? "score" : "score, %");
  add("");
  if (survey.truths.empty())
    for (const Part& part : kParts)
      cells +=
          htmlElement("th", htmlElement("i", "", std::string("class=\"") + part.kind + "\"") + part.title,
                      "class=\"head\"");
  for (const SurveyShape& truth : survey.truths)
    for (const char* title : {"mean", "95 %", "largest"})
      add("t=" + shownNumber(truth.t, 3) + "<br>" + title);
  for (const char* title :
       {"pieces", "genus", "stretch,<br>at most", "time", "CPU<br>time", "peak<br>memory"})
    add(title);
  return htmlElement("tr", cells);
}

std::string figuresOf(const SurveyMethod& method, const SurveyResult& survey) {
  std::string cells;
  if (survey.truths.empty())
    for (const Part& part : kParts)
      cells += tableCell(method.score ? shownNumber((*method.score).*part.points, 3) : "");
  for (const SurveyShape& truth : survey.truths) {
    const SurveyFrame* frame = frameAt(method, truth.t);
    for (double SurfaceDistance::*which :
         {&SurfaceDistance::mean, &SurfaceDistance::p95, &SurfaceDistance::max})
      cells += tableCell(frame && frame->distance ? shownNumber(frame->distance->distance.*which, 3) : "");
  }
  cells += method.surface
               ? tableCell(rangeOf(method, &ShapeMeasures::pieces)) +
                     tableCell(rangeOf(method, &ShapeMeasures::genus)) + tableCell(stretchOf(method))
               : tableCell("") + tableCell("") + tableCell("");
  return cells + tableCell(shownNumber(method.seconds, 3) + " s") +
         tableCell(shownNumber(method.processorSeconds, 3) + " s") +
         tableCell(readableBytes(double(method.peakBytes)));
}

/// Methods with frames, the best first.
std::string ranking(const SurveyResult& survey) {
  double most = 0;
  for (const SurveyMethod& method : survey.methods)
    if (method.score) most = std::max(most, method.score->points());
  std::string rows = headOf(survey);
  for (size_t i = 0; i < survey.methods.size(); ++i) {
    const SurveyMethod& method = survey.methods[i];
    if (method.frames.empty()) continue;
    const std::string name =
        swatch(i) + htmlElement("a", escapedForPage(method.name), "href=\"#" + keyOf(i) + "\"");
    std::string cells = tableCell(method.score ? std::to_string(i + 1) : "") + tableCell(name);
    cells += method.score
                 ? tableCell(shownNumber(method.score->points(), 3)) +
                       tableCell(barOf(*method.score, most > 0 ? most : 1))
                 : htmlElement("td", escapedForPage(method.unranked), "colspan=\"2\" class=\"left soft\"");
    rows += htmlElement("tr", cells + figuresOf(method, survey), "class=\"" + keyOf(i) + "\"");
  }
  return htmlElement("div", htmlElement("table", rows, "id=\"ranking\""), "class=\"wide\"");
}

std::string pictureOf(const std::string& png, const std::string& about) {
  return "<img src=\"data:image/png;base64," + base64Of(png) + "\" alt=\"" + escapedForPage(about) + "\">";
}

/// The times of the pictures, which stay in sight.
std::string timesAbove(const SurveyResult& survey) {
  std::string times;
  for (const double t : survey.sheetTimes) times += htmlElement("span", "t=" + shownNumber(t, 3));
  return times.empty() ? ""
                       : htmlElement("div", times,
                                     "class=\"times\" style=\"grid-template-columns:repeat(" +
                                         std::to_string(survey.sheetTimes.size()) + ",1fr)\"");
}

std::string sheets(const SurveyResult& survey) {
  std::string text = timesAbove(survey);
  if (!survey.truthSheet.empty())
    text += htmlElement("figure", htmlElement("figcaption", htmlElement("b", "as it truly is")) +
                                      pictureOf(survey.truthSheet, "the true frames"));
  for (size_t i = 0; i < survey.methods.size(); ++i) {
    const SurveyMethod& method = survey.methods[i];
    if (method.frames.empty()) continue;
    std::string caption = htmlElement("span", swatch(i) + htmlElement("b", escapedForPage(method.name))) +
                          htmlElement("span", escapedForPage(method.does), "class=\"soft\"");
    if (method.score)
      caption += htmlElement("span", "score " + shownNumber(method.score->points(), 3), "class=\"end soft\"");
    const std::string picture = method.sheet.empty()
                                    ? htmlElement("p", "There is nothing to be seen.", "class=\"soft\"")
                                    : pictureOf(method.sheet, "frames of " + method.name);
    text += htmlElement("figure", htmlElement("figcaption", caption) + picture + listOf(method.notes),
                        "id=\"" + keyOf(i) + "\" class=\"" + keyOf(i) + "\"") +
            "\n";
  }
  return text;
}

std::string refusals(const SurveyResult& survey) {
  std::string items;
  for (const SurveyMethod& method : survey.methods)
    if (!method.refusal.empty())
      items += htmlElement("dt", escapedForPage(method.name) + " " +
                                     htmlElement("span", escapedForPage(method.does),
                                                 "class=\"soft\" style=\"font-weight:400\"")) +
               htmlElement("dd", escapedForPage(method.refusal));
  return items.empty()
             ? ""
             : htmlElement("h2", "Methods without frames") + htmlElement("dl", items, "id=\"refusals\"");
}

std::string shapes(const SurveyResult& survey) {
  std::string rows = htmlElement("tr", htmlElement("th", "t") + htmlElement("th", "file") +
                                           htmlElement("th", "volume") + htmlElement("th", "area") +
                                           htmlElement("th", "pieces") + htmlElement("th", "genus"));
  const auto add = [&](const SurveyShape& s) {
    rows += htmlElement(
        "tr", tableCell(shownNumber(s.t, 3)) + tableCell(escapedForPage(s.name)) +
                  tableCell(shownNumber(s.shape.volume)) + tableCell(shownNumber(s.shape.area)) +
                  tableCell(std::to_string(s.shape.pieces)) + tableCell(std::to_string(s.shape.genus)));
  };
  for (const SurveyShape& input : survey.inputs) add(input);
  for (const SurveyShape& truth : survey.truths) add(truth);
  return htmlElement("div", htmlElement("table", rows, "id=\"shapes\""), "class=\"wide\"");
}

/// Whatever of a method is pointed at, its lines stand out.
std::string highlights(const SurveyResult& survey) {
  std::string rules;
  for (size_t i = 0; i < survey.methods.size(); ++i)
    rules += "main:has(." + keyOf(i) + ":hover) .line:not(." + keyOf(i) + ") { opacity: 0.13; }\n";
  return rules;
}

std::string titleOf(const SurveyResult& survey) {
  std::string title;
  for (const SurveyShape& input : survey.inputs) title += (title.empty() ? "" : " to ") + stemOf(input.name);
  return title;
}

}  // namespace

std::string surveyPage(const SurveyResult& survey) {
  const auto made = std::count_if(survey.methods.begin(), survey.methods.end(),
                                  [](const SurveyMethod& method) { return !method.frames.empty(); });
  const std::string title = escapedForPage(titleOf(survey));
  std::string body = htmlElement("h1", title + ", method by method");
  body += htmlElement("div",
                      std::to_string(made) + " of " + std::to_string(survey.methods.size()) +
                          " methods make this morph; " + survey.voxels +
                          ". Times and memory are of a process of its own for each method, with reading, "
                          "measuring and writing.",
                      "class=\"soft\"");
  body +=
      htmlElement("h2", "Score") + ranking(survey) +
      htmlElement("p",
                  escapedForPage(scoreInWords(survey.truths.size())) +
                      " Stretch is that of the surface beyond the change of size, in the mean over it, where "
                      "a method "
                      "carries surfaces.",
                  "class=\"soft\"");
  body += htmlElement("h2", "Frames at equal times") + sheets(survey);
  body += htmlElement("h2", "Over time") + surveyChart(survey) + refusals(survey);
  body += htmlElement("h2", "Inputs") + shapes(survey);
  if (!survey.notes.empty()) body += htmlElement("h2", "Notes on all methods") + listOf(survey.notes);
  return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         title + "</title>\n<style>" + kStyle + highlights(survey) + "</style>\n</head>\n<body>\n<main>\n" +
         body + "\n</main>\n</body>\n</html>\n";
}

}  // namespace slicemorph

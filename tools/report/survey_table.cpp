#include "tools/report/survey_table.h"

#include "tools/report/page_text.h"

namespace slicemorph {
namespace {

std::string csvCell(double value) { return "," + shownNumber(value, 9); }

std::string csvCell(const std::optional<double>& value) { return value ? csvCell(*value) : ","; }

/// A text in quotation marks, which CSV doubles within.
std::string csvText(const std::string& text) {
  std::string all = "\"";
  for (const char c : text) all += c == '"' ? "\"\"" : std::string(1, c);
  return all + "\"";
}

std::string frameCells(const SurveyFrame& f, bool surface) {
  std::string line = "," + std::to_string(f.number) + csvCell(f.t);
  if (surface)
    line += csvCell(f.shape.volume) + csvCell(f.shape.area) + "," + std::to_string(f.shape.pieces) + "," +
            std::to_string(f.shape.genus);
  else
    line += ",,,,";
  line += csvCell(f.change) + csvCell(f.meanStretch) + csvCell(f.worstStretch);
  if (!f.distance) return line + ",,,,,";
  const SurfaceDistance& d = f.distance->distance;
  return line + "," + csvText(f.distance->to) + csvCell(d.mean) + csvCell(d.p95) + csvCell(d.max) +
         csvCell(f.distance->percent());
}

}  // namespace

std::string surveyTable(const SurveyResult& survey) {
  std::string text =
      "method,rank,score,seconds,cpu_seconds,peak_memory_bytes,frame,t,volume,area,pieces,genus,change,"
      "stretch_mean,stretch_worst,compared_with,distance_mean,distance_p95,distance_max,"
      "distance_percent_of_diagonal,message\n";
  int rank = 0;
  for (const SurveyMethod& method : survey.methods) {
    std::string head = csvText(method.name) + ",";
    head += method.score ? std::to_string(++rank) + csvCell(method.score->points()) : ",";
    head +=
        csvCell(method.seconds) + csvCell(method.processorSeconds) + "," + std::to_string(method.peakBytes);
    const std::string& message = method.refusal.empty() ? method.unranked : method.refusal;
    const std::string tail = "," + (message.empty() ? "" : csvText(message)) + "\n";
    if (method.frames.empty()) text += head + ",,,,,,,,,,,,,," + tail;
    for (const SurveyFrame& frame : method.frames) text += head + frameCells(frame, method.surface) + tail;
  }
  return text;
}

}  // namespace slicemorph

#include "tools/job/survey_methods.h"

#include "io/atomic_file.h"
#include "slicemorph/errors.h"
#include "tools/job/child_program.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace slicemorph {
namespace {

using MethodJson = nlohmann::json;
using Words = std::vector<std::string>;

/// Writes features and regions as a job file; returns its name; empty where there are none.
std::string writeGuidance(const JobTables& all, const ScratchFolder& scratch) {
  if (all.features.empty() && all.regions.empty()) return "";
  JobTables tables;
  tables.inputs = all.inputs, tables.features = all.features, tables.regions = all.regions;
  const std::string file = scratch.file("guidance.toml");
  writeTextFile(file, givenJobText(OptionSet(kMorph), tables));
  return file;
}

/// One method's command line, and what it does without.
struct MethodCommand {
  Words words;
  std::vector<std::string> notes;
};

MethodCommand commandOf(const SurveyJob& job, const SurveyJob::Asked& asked, const std::string& guidance,
                        const std::string& files, const std::string& report) {
  const MethodTraits& can = asked.method->can;
  MethodCommand command;
  command.words = {"morph"};
  command.words.insert(command.words.end(), job.morph.settings.inputs.begin(),
                       job.morph.settings.inputs.end());
  const auto add = [&](const std::string& name, const std::string& value) {
    command.words.push_back("--" + name + "=" + value);
  };
  for (const auto& [row, texts] : job.given) {
    if (row->needs && !(can.*row->needs)) {
      command.notes.push_back("without --" + row->name + ", which this method does not take");
      continue;
    }
    for (const std::string& text : texts)
      row->type == OptionType::kFlag ? command.words.push_back("--" + row->name) : add(row->name, text);
  }
  if (!guidance.empty() && can.guided) add("config", guidance);
  if (!guidance.empty() && !can.guided)
    command.notes.push_back("without features and regions, which this method does not take");
  add("method", asked.text), add("output", files), add("report", report), add("velocity", "none");
  if (can.surface) add("grids", "surface");
  return command;
}

/// What the program said, sorted: its error, and its notes and warnings.
struct Said {
  std::string error;
  std::vector<std::string> notes;
};

Said sorted(const std::string& text, const std::string& scratch) {
  Said said;
  std::istringstream lines(text);
  bool error = false;
  for (std::string line; std::getline(lines, line);) {
    for (size_t at = 0; (at = line.find(scratch, at)) != std::string::npos;) line.erase(at, scratch.size());
    const auto begins = [&](const char* start) { return line.rfind(start, 0) == 0; };
    if (begins("Run 'slicemorph")) continue;
    if (begins("slicemorph: ")) error = true, line.erase(0, std::string("slicemorph: ").size());
    if (error)
      said.error += (said.error.empty() ? "" : " ") + line;
    else if (begins("note: ") || begins("warning: "))
      said.notes.push_back(line.substr(line.find(' ') + 1));
  }
  return said;
}

std::vector<SurveyFrame> framesOfReport(const MethodJson& report) {
  std::vector<SurveyFrame> frames;
  for (const MethodJson& row : report["frames"]) {
    SurveyFrame frame;
    frame.number = row["frame"], frame.t = row["t"];
    frame.weights = row["weights"].get<std::vector<double>>();
    if (!row["volume"].is_null()) frame.shape = {row["volume"], row["area"], row["pieces"], row["genus"]};
    if (!row["symmetricDifference"].is_null()) frame.change = row["symmetricDifference"].get<double>();
    if (row.contains("stretch"))
      frame.meanStretch = row["stretch"]["mean"].get<double>(),
      frame.worstStretch = row["stretch"]["worst"].get<double>();
    frames.push_back(frame);
  }
  return frames;
}

MethodRun runMethod(const SurveyJob& job, size_t index, const std::string& guidance,
                    const ScratchFolder& scratch, const Progress& cancel) {
  const SurveyJob::Asked& asked = job.methods[index];
  MethodRun run;
  SurveyMethod& method = run.method;
  method.name = asked.text, method.does = asked.method->help, method.surface = asked.method->can.surface;
  const std::string number = std::to_string(index + 1), report = scratch.file(number + ".json");
  run.files = scratch.file(number + ".####.vdb");
  const MethodCommand command = commandOf(job, asked, guidance, run.files, report);
  const ChildEnd end = runOwnProgram(command.words, cancel);
  method.seconds = end.seconds, method.processorSeconds = end.processorSeconds,
  method.peakBytes = end.peakBytes;
  const Said said = sorted(end.said, scratch.file(""));
  method.notes = command.notes;
  method.notes.insert(method.notes.end(), said.notes.begin(), said.notes.end());
  if (!end.done) {
    method.refusal = !end.trouble.empty() ? end.trouble
                     : said.error.empty() ? "failed without a word"
                                          : said.error;
    return run;
  }
  std::ifstream file(report);
  method.frames = framesOfReport(MethodJson::parse(file));
  return run;
}

}  // namespace

std::vector<MethodRun> runMethods(const SurveyJob& job, const ScratchFolder& scratch, Progress& progress) {
  const std::string guidance = writeGuidance(job.morph.tables, scratch);
  std::vector<MethodRun> runs;
  for (size_t i = 0; i < job.methods.size(); ++i) {
    progress.report("running the methods", double(i) / double(job.methods.size()));
    runs.push_back(runMethod(job, i, guidance, scratch, progress));
  }
  return runs;
}

}  // namespace slicemorph

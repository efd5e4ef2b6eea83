#include "tools/commands/compare_command.h"

#include "io/atomic_file.h"
#include "slicemorph/io/output.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/compare_shapes.h"
#include "tools/job/limit_threads.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"
#include "tools/report/comparison_report.h"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace slicemorph {
namespace {

std::string spelled(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void writeReports(const std::vector<std::string>& reports, const Comparison& c) {
  for (const std::string& path : reports) {
    const nlohmann::ordered_json whole = jsonOf(c);
    writeTextFile(
        path, OutputName(path).extension() == ".json" ? spelled(whole) : comparisonTable(c.labels, whole));
  }
}

void printLabels(const std::vector<LabelComparison>& labels) {
  if (labels.empty()) return;
  std::printf("%-8s %-12s %-12s %-9s %-10s %-10s %-10s %s\n", "label", "A ml", "B ml", "dice", "mean mm",
              "95% mm", "max mm", "centroids mm");
  for (const LabelComparison& l : labels) {
    std::printf("%-8lld %-12.6g %-12.6g %-9.6f ", static_cast<long long>(l.label), l.volume[0] / 1000,
                l.volume[1] / 1000, l.dice);
    if (l.distance)
      std::printf("%-10.5g %-10.5g %-10.5g %.5g\n", l.distance->mean, l.distance->p95, l.distance->max,
                  (l.centroid[1] - l.centroid[0]).length());
    else
      std::printf("%s\n", !l.voxels[1] ? "only in A" : !l.voxels[0] ? "only in B" : "lost on A's voxels");
  }
}

void printText(const Comparison& c) {
  const auto distance = [&](const char* name, double unit, const std::string& what) {
    std::printf("%-14s mean %-12.6g 99%% %-12.6g max %-12.6g %s\n", name, c.distance.mean / unit,
                c.distance.p99 / unit, c.distance.max / unit, what.c_str());
  };
  const ShapeMeasures &a = c.shapes[0], &b = c.shapes[1];
  distance("distance", 1, "world units");
  distance("", c.voxelSizes[0], "voxels of A (" + formatNumber(c.voxelSizes[0]) + ")");
  std::printf("%-14s A %-15.8g B %-15.8g B / A %.6f\n", "volume", a.volume, b.volume, b.volume / a.volume);
  std::printf("%-14s A %-15.8g B %-15.8g B / A %.6f\n", "area", a.area, b.area, b.area / a.area);
  std::printf("%-14s A %-15d B %d\n", "pieces", a.pieces, b.pieces);
  std::printf("%-14s A %-15d B %d\n", "genus", a.genus, b.genus);
  std::printf("%-14s %.6f\n", "dice", c.overlap.dice);
  printLabels(c.labels);
}

void runCompare(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  CompareJob job;
  job.inputs[0] = given.input, job.inputs[1] = given.other;
  job.load = loadSettings(options);
  for (const std::string& input : job.inputs) checkInputExists(input);
  for (const std::string& report : given.reports) {
    checkExtension(report, {".json", ".csv"});
    checkOutputPath(report);
  }
  const auto limit = limitThreads(given.threads);
  job.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  const Comparison result = compareShapes(job, events);
  writeReports(given.reports, result);
  if (given.json)
    std::printf("%s", spelled(jsonOf(result)).c_str());
  else
    printText(result);
}

}  // namespace

void addCompareCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("compare",
                             "Distance between two surfaces (both ways), volumes, areas, "
                             "topology and overlap; of label maps also label by label; meshes are voxelised");
  const auto options = addOptions(*command, kCompare);
  command->callback([options] { runCompare(*options); });
}

}  // namespace slicemorph

#include "tools/commands/compare_command.h"

#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"
#include "io/atomic_file.h"
#include "slicemorph/io/output.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/job/compare_maps.h"
#include "tools/job/load_settings.h"
#include "tools/job/memory_need.h"
#include "tools/job/option_values.h"
#include "tools/report/comparison_report.h"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace slicemorph {
namespace {

struct CompareSettings {
  std::string inputs[2];
  LoadOptions load;
  std::vector<std::string> reports;  ///< .json, .csv
  bool json = false, quiet = false, verbose = false;
};

struct Comparison {
  ShapeMeasures shapes[2];
  double voxelSizes[2] = {0, 0};
  SurfaceDistance distance;
  Overlap overlap;
  std::vector<LabelComparison> labels;  ///< of two label maps
};

Comparison compare(const CompareSettings& s) {
  Comparison result;
  FloatGrid::ConstPtr grids[2];
  Mesh meshes[2];
  std::shared_ptr<const Image> maps[2];
  for (int i = 0; i < 2; ++i) {
    const LoadedObject loaded = loadObject(s.inputs[i], s.load);
    printNotes(s.inputs[i] + ": ", loaded.notes, s.quiet, s.verbose);
    grids[i] = loaded.object.levelSet;
    if (loaded.labels) maps[i] = loaded.image;
  }
  const std::string both = s.inputs[0] + " and " + s.inputs[1];
  if (maps[0] && maps[1]) {
    MapComparison compared = compareMaps(*maps[0], *maps[1], s.load.memory, both);
    printNotes(both + ": ", compared.notes, s.quiet, s.verbose);
    result.labels = std::move(compared.labels);
  }
  require(s.load.memory, both, needOfComparison(*grids[0], *grids[1]));
  for (int i = 0; i < 2; ++i) {
    meshes[i] = surfaceOf(*grids[i]);
    result.shapes[i] = measureMesh(meshes[i]);
    result.voxelSizes[i] = grids[i]->voxelSize()[0];
  }
  result.distance = surfaceDistance(meshes[0], meshes[1]);
  result.overlap = overlap(*grids[0], *grids[1]);
  return result;
}

nlohmann::ordered_json jsonOfComparison(const CompareSettings& s, const Comparison& c) {
  const auto distance = [&](double unit) {
    return nlohmann::ordered_json{{"mean", c.distance.mean / unit},
                                  {"p95", c.distance.p95 / unit},
                                  {"p99", c.distance.p99 / unit},
                                  {"max", c.distance.max / unit}};
  };
  nlohmann::ordered_json json;
  for (int i = 0; i < 2; ++i) {
    const ShapeMeasures& shape = c.shapes[i];
    json[i ? "b" : "a"] = {{"file", s.inputs[i]}, {"voxelSize", c.voxelSizes[i]}, {"volume", shape.volume},
                           {"area", shape.area},  {"pieces", shape.pieces},       {"genus", shape.genus}};
  }
  json["distance"] = distance(1);
  json["distanceVoxels"] = distance(c.voxelSizes[0]);
  json["dice"] = c.overlap.dice;
  json["intersection"] = c.overlap.intersection;
  json["symmetricDifference"] = c.overlap.symmetricDifference;
  if (!c.labels.empty()) json["labels"] = labelsJson(c.labels);
  return json;
}

std::string spelled(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void writeReports(const CompareSettings& s, const Comparison& c) {
  for (const std::string& path : s.reports) {
    const nlohmann::ordered_json whole = jsonOfComparison(s, c);
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
  const CompareSettings s = {{given.input, given.other},
                             loadSettings(options),
                             given.reports,
                             given.json,
                             given.quiet,
                             given.verbose};
  for (const std::string& input : s.inputs) checkInputExists(input);
  for (const std::string& report : s.reports) {
    checkExtension(report, {".json", ".csv"});
    checkOutputPath(report);
  }
  const auto limit = limitThreads(given.threads);
  s.load.memory.enforce();
  const Comparison result = compare(s);
  writeReports(s, result);
  if (s.json)
    std::printf("%s", spelled(jsonOfComparison(s, result)).c_str());
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

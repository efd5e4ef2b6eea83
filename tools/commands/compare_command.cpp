#include "tools/commands/compare_command.h"

#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/job/load_settings.h"
#include "tools/job/memory_need.h"
#include "tools/job/option_values.h"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace slicemorph {
namespace {

struct CompareSettings {
  std::string inputs[2];
  LoadOptions load;
  bool json = false, quiet = false, verbose = false;
};

struct Comparison {
  ShapeMeasures shapes[2];
  double voxelSizes[2] = {0, 0};
  SurfaceDistance distance;
  Overlap overlap;
};

Comparison compare(const CompareSettings& s) {
  Comparison result;
  FloatGrid::ConstPtr grids[2];
  Mesh meshes[2];
  for (int i = 0; i < 2; ++i) {
    const LoadedObject loaded = loadObject(s.inputs[i], s.load);
    printNotes(s.inputs[i] + ": ", loaded.notes, s.quiet, s.verbose);
    grids[i] = loaded.object.levelSet;
  }
  require(s.load.memory, s.inputs[0] + " and " + s.inputs[1], needOfComparison(*grids[0], *grids[1]));
  for (int i = 0; i < 2; ++i) {
    meshes[i] = surfaceOf(*grids[i]);
    result.shapes[i] = measureMesh(meshes[i]);
    result.voxelSizes[i] = grids[i]->voxelSize()[0];
  }
  result.distance = surfaceDistance(meshes[0], meshes[1]);
  result.overlap = overlap(*grids[0], *grids[1]);
  return result;
}

void printJson(const CompareSettings& s, const Comparison& c) {
  const auto distance = [&](double unit) {
    return nlohmann::ordered_json{
        {"mean", c.distance.mean / unit}, {"p99", c.distance.p99 / unit}, {"max", c.distance.max / unit}};
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
  std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
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
}

void runCompare(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  const CompareSettings s = {
      {given.input, given.other}, loadSettings(options), given.json, given.quiet, given.verbose};
  for (const std::string& input : s.inputs) checkInputExists(input);
  const auto limit = limitThreads(given.threads);
  s.load.memory.enforce();
  const Comparison result = compare(s);
  if (s.json)
    printJson(s, result);
  else
    printText(result);
}

}  // namespace

void addCompareCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand("compare",
                                             "Distance between two surfaces (both ways), volumes, areas, "
                                             "topology and overlap; meshes are voxelised");
  const auto options = addOptions(*command, kCompare);
  command->callback([options] { runCompare(*options); });
}

}  // namespace slicemorph

#include "tools/morph_report.h"

#include "tools/common_options.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

const char* nameOf(Method method) {
  if (method == Method::kDissolve) return "dissolve";
  return method == Method::kSdf ? "sdf" : method == Method::kLevelSet ? "levelset" : "slices";
}

Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json describeShape(const ShapeMeasures& shape) {
  return {{"volume", shape.volume}, {"area", shape.area}, {"pieces", shape.pieces}, {"genus", shape.genus}};
}

Json summarise(const std::vector<Json>& frames) {
  double sum = 0, largest = 0, lowestRatio = INFINITY, lowestSizeLinear = INFINITY, fold = 0;
  int steps = 0, pieces = 0, genusChanges = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const Json& frame = frames[i];
    if (frame["symmetricDifference"].is_number()) {
      const double difference = frame["symmetricDifference"];
      sum += difference, largest = std::max(largest, difference), ++steps;
    }
    if (frame["volume"].is_null()) continue;
    lowestRatio = std::min(lowestRatio, frame["volumeRatio"].get<double>());
    lowestSizeLinear = std::min(lowestSizeLinear, frame["volumeRatioSizeLinear"].get<double>());
    pieces = std::max(pieces, frame["pieces"].get<int>());
    fold = std::max(fold, frame["foldShare"].get<double>());
    genusChanges += i && frame["genus"] != frames[i - 1]["genus"];
  }
  if (std::isinf(lowestRatio)) return Json::object();
  return {{"pop", sum > 0 ? Json(largest * steps / sum) : Json(nullptr)},
          {"lowestVolumeRatio", lowestRatio},
          {"lowestVolumeRatioSizeLinear", lowestSizeLinear},
          {"mostPieces", pieces},
          {"genusChanges", genusChanges},
          {"largestFoldShare", fold}};
}

}  // namespace

Json describeJob(const MorphSettings& s) {
  Json job = {{"inputs", s.inputs}, {"output", s.output}, {"method", nameOf(s.method)}};
  job["frames"] = s.frames.size();
  Json times = Json::array();
  for (const FrameJob& frame : s.frames) times.push_back(frame.t ? Json(*frame.t) : Json(frame.weights));
  job["times"] = times;
  job["voxelSize"] = s.load.voxelSize;
  job["resolution"] = s.load.resolution;
  job["iso"] = s.load.iso;
  job["slices"] = s.plan.slices;
  job["samples"] = s.plan.samples;
  job["axis"] = {s.plan.axis[0], s.plan.axis[1], s.plan.axis[2]};
  job["spine"] = s.plan.spine == SpineKind::kStraight ? "straight" : s.plan.spine == SpineKind::kCurved ? "curved" : "auto";
  job["align"] = s.plan.align == Align::kNone ? "none" : "auto";
  job["fps"] = s.framesPerSecond;
  job["grids"] = s.grids;
  job["conserve"] = s.conserve;
  job["velocity"] = {{"name", s.velocity.name}, {"unit", s.velocity.perFrame ? "frame" : "second"}, {"add", s.velocity.add}};
  return job;
}

Json describeFrame(const FrameJob& job, const FrameFigures& figures,
                   const std::vector<ShapeMeasures>& inputs) {
  double linear = 0, size = 0;
  for (size_t k = 0; k < inputs.size(); ++k) {
    linear += job.weights[k] * inputs[k].volume;
    size += job.weights[k] * std::cbrt(inputs[k].volume);
  }
  Json frame = {{"frame", job.number}, {"t", orNull(job.t)}, {"weights", job.weights}, {"file", job.path}};
  frame["voxelSize"] = figures.voxelSize;
  const auto ofShape = [&](auto value) { return figures.shape ? Json(value(*figures.shape)) : Json(nullptr); };
  frame["volume"] = ofShape([](const ShapeMeasures& s) { return s.volume; });
  frame["volumeLinear"] = linear;
  frame["volumeRatio"] = ofShape([&](const ShapeMeasures& s) { return s.volume / linear; });
  // Lengths are what a morph interpolates linearly, so the volume of a growing shape follows a cubic.
  frame["volumeRatioSizeLinear"] = ofShape([&](const ShapeMeasures& s) { return s.volume / (size * size * size); });
  frame["area"] = ofShape([](const ShapeMeasures& s) { return s.area; });
  frame["pieces"] = ofShape([](const ShapeMeasures& s) { return s.pieces; });
  frame["genus"] = ofShape([](const ShapeMeasures& s) { return s.genus; });
  frame["foldShare"] = figures.foldShare;
  frame["grids"] = Json::array();
  for (const GridFigures& g : figures.grids)
    frame["grids"].push_back({{"name", g.name}, {"activeVoxels", g.activeVoxels}, {"total", orNull(g.total)}, {"peak", orNull(g.peak)}});
  frame["symmetricDifference"] = orNull(figures.symmetricDifference);
  frame["seconds"] = {{"evaluate", figures.seconds.evaluate},
                      {"measure", figures.seconds.measure},
                      {"write", figures.seconds.write}};
  return frame;
}

void writeReport(const MorphSettings& settings, const ReportParts& parts) {
  Json report;
  report["settings"] = describeJob(settings);
  report["inputs"] = Json::array();
  for (size_t k = 0; k < settings.inputs.size(); ++k) {
    Json input = {{"file", settings.inputs[k]}};
    input.update(describeShape(parts.inputs[k]));
    report["inputs"].push_back(input);
  }
  report["notes"] = parts.notes;
  report["frames"] = parts.frames;
  report["summary"] = summarise(parts.frames);
  if (parts.restDistance) report["summary"]["restDistanceVoxels"] = *parts.restDistance;
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  report["seconds"] = {{"load", parts.loadSeconds}, {"plan", parts.planSeconds}};
  report["peakMemoryBytes"] = std::int64_t(usage.ru_maxrss) * 1024;
  // Names of files need not be UTF-8.
  writeTextFile(settings.report, report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace slicemorph

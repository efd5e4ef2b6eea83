#include "tools/report/morph_report.h"

#include "io/atomic_file.h"
#include "slicemorph/io/output.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// Of an in-between of nothing all that is expected is 0.
double ratioOf(double value, double expected) { return value == 0 && expected == 0 ? 1 : value / expected; }

Json describeShape(const ShapeMeasures& shape) {
  return {{"volume", shape.volume}, {"area", shape.area}, {"pieces", shape.pieces}, {"genus", shape.genus}};
}

/// Four rows of a matrix that takes points of the file, as columns (x, y, z, 1), to where they are in the job.
Json describePlacing(const Placing& placing) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    Json row = Json::array();
    for (int c = 0; c < 3; ++c) row.push_back(placing.scale * placing.rotation(r, c));
    row.push_back(placing.move[r]);
    rows.push_back(row);
  }
  rows.push_back({0, 0, 0, 1});
  return rows;
}

Json summarise(const std::vector<Json>& frames) {
  double sum = 0, largest = 0, lowestRatio = INFINITY, lowestSizeLinear = INFINITY, fold = 0, area = 0,
         beyond = 0;
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
    if (frame.contains("areaRatio")) area = std::max(area, frame["areaRatio"].get<double>());
    if (frame.contains("stretch")) beyond = std::max(beyond, frame["stretch"]["shareBeyond3"].get<double>());
    pieces = std::max(pieces, frame["pieces"].get<int>());
    fold = std::max(fold, frame["foldShare"].get<double>());
    genusChanges += i && frame["genus"] != frames[i - 1]["genus"];
  }
  if (std::isinf(lowestRatio)) return Json::object();
  return {{"pop", sum > 0 ? Json(largest * steps / sum) : Json(nullptr)},
          {"lowestVolumeRatio", lowestRatio},
          {"lowestVolumeRatioSizeLinear", lowestSizeLinear},
          {"highestAreaRatio", area},
          {"largestShareBeyond3", beyond},
          {"mostPieces", pieces},
          {"genusChanges", genusChanges},
          {"largestFoldShare", fold}};
}

}  // namespace

Json describeFrame(const FrameFigures& figures, const std::vector<ShapeMeasures>& inputs) {
  double linear = 0, size = 0, area = 0;
  for (size_t k = 0; k < inputs.size(); ++k) {
    linear += figures.weights[k] * inputs[k].volume;
    area += figures.weights[k] * inputs[k].area;
    size += figures.weights[k] * std::cbrt(inputs[k].volume);
  }
  Json frame = {{"frame", figures.number},
                {"t", orNull(figures.t)},
                {"weights", figures.weights},
                {"file", figures.file}};
  frame["voxelSize"] = figures.voxelSize;
  const auto ofShape = [&](auto value) {
    return figures.shape ? Json(value(*figures.shape)) : Json(nullptr);
  };
  frame["volume"] = ofShape([](const ShapeMeasures& s) { return s.volume; });
  frame["volumeLinear"] = linear;
  frame["volumeRatio"] = ofShape([&](const ShapeMeasures& s) { return ratioOf(s.volume, linear); });
  // A morph interpolates lengths linearly, so the cube root of the volume is expected to be linear
  // in the weights.
  frame["volumeRatioSizeLinear"] =
      ofShape([&](const ShapeMeasures& s) { return ratioOf(s.volume, size * size * size); });
  frame["area"] = ofShape([](const ShapeMeasures& s) { return s.area; });
  frame["areaLinear"] = area;
  // What is crumpled has more surface than the ends.
  frame["areaRatio"] = ofShape([&](const ShapeMeasures& s) { return ratioOf(s.area, area); });
  if (figures.strain)
    frame["stretch"] = {{"mean", figures.strain->meanStretch},
                        {"worst", figures.strain->worstStretch},
                        {"shareBeyond3", figures.strain->muchStretched},
                        {"meanTurnDegrees", figures.strain->meanTurn * 180 / M_PI}};
  frame["pieces"] = ofShape([](const ShapeMeasures& s) { return s.pieces; });
  frame["genus"] = ofShape([](const ShapeMeasures& s) { return s.genus; });
  frame["foldShare"] = figures.foldShare;
  frame["grids"] = Json::array();
  for (const GridFigures& g : figures.grids)
    frame["grids"].push_back({{"name", g.name},
                              {"activeVoxels", g.activeVoxels},
                              {"total", orNull(g.total)},
                              {"peak", orNull(g.peak)}});
  if (!figures.labels.empty()) {
    frame["labels"] = Json::array();
    for (const LabelMeasures& m : figures.labels)
      frame["labels"].push_back({{"label", m.label},
                                 {"voxels", m.voxels},
                                 {"volumeMl", m.volume / 1000},
                                 {"areaMm2", m.area},
                                 {"extentsMm", {m.extents[0], m.extents[1], m.extents[2]}},
                                 {"centroidMm", {m.centroid[0], m.centroid[1], m.centroid[2]}}});
  }
  frame["symmetricDifference"] = orNull(figures.symmetricDifference);
  frame["seconds"] = {{"evaluate", figures.seconds.evaluate},
                      {"measure", figures.seconds.measure},
                      {"write", figures.seconds.write}};
  return frame;
}

LandmarkErrors landmarkErrors(const std::vector<std::vector<Vec3d>>& landmarks, const MorphPlan& plan) {
  LandmarkErrors e;
  std::vector<Vec3d> points;
  points.reserve(landmarks.size());
  for (const std::vector<Vec3d>& mark : landmarks) points.push_back(mark.front());
  const std::vector<Vec3d> arrived = plan.correspond(points, 0, plan.objectCount() - 1);
  std::vector<double> off;
  e.count = landmarks.size();
  for (size_t i = 0; i < landmarks.size(); ++i) {
    off.push_back((arrived[i] - landmarks[i].back()).length());
    e.before += (points[i] - landmarks[i].back()).length() / double(e.count);
    e.mean += off.back() / double(e.count);
  }
  std::sort(off.begin(), off.end());
  e.median = off[off.size() / 2], e.most = off.back();
  return e;
}

namespace {

Json describe(const LandmarkErrors& e) {
  return {{"count", e.count},
          {"meanDistanceBefore", e.before},
          {"mean", e.mean},
          {"median", e.median},
          {"max", e.most}};
}

/// A CSV table with a line per label of every frame, or per frame for its shape.
std::string asTable(const std::vector<Json>& frames) {
  std::string text =
      "frame,t,file,label,voxels,volume_ml,area_mm2,extent_i_mm,extent_j_mm,extent_k_mm,x_mm,y_mm,z_mm\n";
  const auto number = [](const Json& value) { return value.is_null() ? std::string() : value.dump(); };
  for (const Json& frame : frames) {
    std::string file = frame["file"];
    for (size_t at = 0; (at = file.find('"', at)) != std::string::npos; at += 2) file.insert(at, 1, '"');
    const std::string head = number(frame["frame"]) + "," + number(frame["t"]) + ",\"" + file + "\",";
    if (!frame.contains("labels")) {
      const Json& volume = frame["volume"];
      text += head + ",," + (volume.is_null() ? "" : Json(volume.get<double>() / 1000).dump()) + "," +
              number(frame["area"]) + ",,,,,,\n";
      continue;
    }
    for (const Json& l : frame["labels"]) {
      text += head + number(l["label"]) + "," + number(l["voxels"]) + "," + number(l["volumeMl"]) + "," +
              number(l["areaMm2"]);
      for (const char* key : {"extentsMm", "centroidMm"})
        for (int d = 0; d < 3; ++d) text += "," + number(l[key][d]);
      text += "\n";
    }
  }
  return text;
}

Json reportOf(const ReportParts& parts) {
  Json report;
  report["settings"] = parts.settings;
  report["inputs"] = Json::array();
  for (size_t k = 0; k < parts.inputs.size(); ++k) {
    Json input = {{"file", parts.inputNames[k]}};
    input.update(describeShape(parts.inputs[k]));
    if (k < parts.placings.size() && !parts.placings[k].isIdentity())
      input["transform"] = describePlacing(parts.placings[k]);
    report["inputs"].push_back(input);
  }
  report["notes"] = sentencesOf(parts.notes);
  report["frames"] = parts.frames;
  report["summary"] = summarise(parts.frames);
  if (parts.overlap) {
    Json turns = Json::array();
    const auto known = [](double value) { return value < 0 ? Json(nullptr) : Json(value); };
    for (const TurnChoice& t : parts.turns)
      turns.push_back(
          {{"degrees", t.degrees}, {"innerDistortion", known(t.distortion)}, {"margin", known(t.margin)}});
    report["plan"] = {{"overlap", *parts.overlap}, {"turns", turns}};
  }
  if (parts.landmarks) report["landmarks"] = describe(*parts.landmarks);
  if (parts.checkLandmarks) report["checkLandmarks"] = describe(*parts.checkLandmarks);
  if (parts.restDistance) report["summary"]["restDistanceVoxels"] = *parts.restDistance;
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  report["seconds"] = {{"load", parts.loadSeconds}, {"plan", parts.planSeconds}};
  report["peakMemoryBytes"] = std::int64_t(usage.ru_maxrss) * 1024;
  return report;
}

}  // namespace

void writeReports(const std::vector<std::string>& paths, const ReportParts& parts) {
  const Json report = reportOf(parts);
  for (const std::string& path : paths) {
    const std::string extension = OutputName(path).extension();
    // Names of files need not be UTF-8: JSON replaces what is not.
    writeTextFile(path, extension == ".csv" ? asTable(parts.frames)
                        : extension == ".html"
                            ? pageOf(report, parts.page)
                            : report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  }
}

}  // namespace slicemorph

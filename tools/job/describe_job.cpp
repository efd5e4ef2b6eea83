#include "tools/job/describe_job.h"

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

const char* nameOf(Timing timing) {
  if (timing == Timing::kCatmullRom) return "catmull-rom";
  return timing == Timing::kSmoothstep ? "smoothstep" : "linear";
}

const char* nameOf(ContourPath path) {
  if (path == ContourPath::kHermite) return "hermite";
  return path == ContourPath::kIntrinsic ? "intrinsic" : "linear";
}

Json toJson(const Vec3d& v) { return {v[0], v[1], v[2]}; }

Json toJson(const Feature& feature) {
  const char* kinds[] = {"point", "line", "disk"};
  Json json = {{"name", feature.name}, {"kind", kinds[int(feature.kind)]}, {"places", Json::array()}};
  for (const std::vector<Vec3d>& ofInput : feature.positions) {
    json["places"].push_back(Json::array());
    for (const Vec3d& position : ofInput) json["places"].back().push_back(toJson(position));
  }
  if (feature.kind != Feature::Kind::kDisk) return json;
  json["normals"] = Json::array();
  for (const Vec3d& normal : feature.normals) json["normals"].push_back(toJson(normal));
  json["radii"] = feature.radii;
  return json;
}

Json toJson(const Region& region) {
  Json json = {{"name", region.name}, {"on", region.object + 1}};
  if (region.kind == Region::Kind::kSphere)
    json["sphere"] = {{"center", toJson(region.center)}, {"radius", region.radius}};
  else if (region.kind == Region::Kind::kBox)
    json["box"] = {{"min", toJson(region.box.min())}, {"max", toJson(region.box.max())}};
  else
    json["spine"] = {region.from, region.to};
  json["border"] = region.border;
  json["weights"] = region.weights;
  return json;
}

}  // namespace

Json describeJob(const MorphSettings& s) {
  Json job = {{"inputs", s.inputs}, {"output", s.output}, {"method", s.method}};
  for (const MethodParameter& parameter : methodNamed(s.method).parameters)
    job["parameters"][parameter.name] = valueOf(parameter, s.parameters);
  job["frames"] = s.frames.size();
  Json times = Json::array();
  for (const FrameJob& frame : s.frames) times.push_back(frame.t ? Json(*frame.t) : Json(frame.weights));
  job["times"] = times;
  job["keys"] = Json::array();
  for (const WeightKey& key : s.course.keys)
    job["keys"].push_back({{"at", key.at}, {"weights", key.weights}});
  job["timing"] = nameOf(s.course.timing);
  job["ease"] = {s.course.easing.x1, s.course.easing.y1, s.course.easing.x2, s.course.easing.y2};
  job["interpolation"] = nameOf(s.plan.path);
  job["features"] = Json::array();
  for (const Feature& feature : s.plan.features) job["features"].push_back(toJson(feature));
  job["regions"] = Json::array();
  for (const Region& region : s.plan.regions) job["regions"].push_back(toJson(region));
  job["voxelSize"] = s.load.voxelSize;
  job["resolution"] = s.load.resolution;
  job["iso"] = s.load.iso;
  job["slices"] = s.plan.slices;
  job["samples"] = s.plan.samples;
  job["axis"] = {s.plan.axis[0], s.plan.axis[1], s.plan.axis[2]};
  job["spine"] = s.plan.spine == SpineKind::kStraight ? "straight"
                 : s.plan.spine == SpineKind::kCurved ? "curved"
                                                      : "auto";
  job["align"] = s.plan.align == Align::kNone ? "none" : "auto";
  job["fps"] = s.framesPerSecond;
  job["image"] = s.load.imageKind == ImageKind::kGrey     ? "grey"
                 : s.load.imageKind == ImageKind::kLabels ? "labels"
                                                          : "auto";
  job["furtherIsos"] = s.load.furtherIsos;
  job["isosByInput"] = s.load.isosByInput;
  job["spacing"] = {s.load.image.spacing[0], s.load.image.spacing[1], s.load.image.spacing[2]};
  job["force"] = s.load.image.force;
  job["like"] = s.like;
  job["glb"] = {{"metres", s.glb.metres}, {"zUp", s.glb.zUp}};
  if (s.toFrameImages()) {
    job["exr"] = s.exrContent == ExrContent::kSlices ? "slices" : "picture";
    job["imageOptions"] = Json::object();
    for (const auto* options : {&s.pictureOptions, &s.sliceOptions})
      for (const auto& [name, value] : *options) job["imageOptions"][name] = value;
  }
  job["grids"] = s.grids;
  job["conserve"] = s.conserve;
  job["velocity"] = {
      {"name", s.velocity.name}, {"unit", s.velocity.perFrame ? "frame" : "second"}, {"add", s.velocity.add}};
  return job;
}

}  // namespace slicemorph

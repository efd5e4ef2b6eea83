#include "tools/job/limit_threads.h"
#include "tools/job/load_settings.h"
#include "tools/job/morph_session.h"
#include "tools/job/option_values.h"
#include "tools/slicer/slicer_events.h"
#include "tools/slicer/slicer_module.h"

#include <string>
#include <utility>
#include <vector>

namespace slicemorph {
namespace {

/// Share of reading and planning in the time of a run that makes one frame.
constexpr double kPlanningShare = 0.6;

/// One of the three kinds of objects that can be morphed: its parameters are `firstVolume`, `secondVolume`, `outputVolume`.
struct MorphKind {
  ParameterKind kind;
  const char *ending, *group, *one, *image;
};

constexpr MorphKind kMorphKinds[] = {
    {ParameterKind::kVolume, "Volume", "Volumes", "volume", "grey"},
    {ParameterKind::kLabelMap, "Labels", "Label maps and segmentations", "label map", "labels"},
    {ParameterKind::kModel, "Model", "Models", "model", nullptr}};

ParameterGroup groupOf(const MorphKind& kind) {
  const std::string end = kind.ending, one = kind.one;
  return {kind.group,
          "Give two objects of one kind, here or in another group.",
          false,
          {inputOf(kind.kind, "first" + end, "First " + one, "The " + one + " at time 0"),
           inputOf(kind.kind, "second" + end, "Second " + one, "The " + one + " at time 1"),
           outputOf(kind.kind, "output" + end, "In-between " + one, "The " + one + " at the time below",
                    "first" + end)}};
}

ParameterGroup timeGroup() {
  ModuleParameter time;
  time.kind = ParameterKind::kNumber, time.name = "time", time.label = "Time", time.value = "0.5";
  time.help = "Of the in-between object: 0 is the first one, 1 the second";
  time.range = {0, 1, false}, time.step = 0.01;
  ModuleParameter frames;
  frames.kind = ParameterKind::kInteger, frames.name = "frames", frames.label = "Frames", frames.value = "0";
  frames.help = "So many frames from the first object to the second, as files in the folder; 0: none";
  frames.range = {0, 1000, false};
  return {
      "Time",
      "One object in the scene, or a sequence of files.",
      false,
      {time, frames,
       folderOf("folder", "Folder of the frames",
                "Frames are named morph.0001.nrrd or morph.0001.vtp, and so on; of no effect where there are "
                "none")}};
}

ParameterGroup landmarkGroup() {
  const std::string help = "Control points on it; the n-th of one list belongs with the n-th of the other";
  return {"Landmarks",
          "Places that belong together, where the match needs help.",
          true,
          {inputOf(ParameterKind::kPoints, "firstLandmarks", "On the first object", help),
           inputOf(ParameterKind::kPoints, "secondLandmarks", "On the second object", help)}};
}

ParameterGroup matchingGroup() {
  ParameterGroup group{"Shape and matching", "As the options of slicemorph morph.", true, {}};
  for (const char* option : {"iso", "resolution", "voxel-size", "shell", "method", "align", "upright",
                             "slices", "samples", "axis", "spine", "interpolation"})
    group.parameters.push_back(ofOption(kMorph, option));
  return group;
}

bool isGivenAnyOf(const ModuleValues& values, const std::string& end) {
  return values.given("first" + end) || values.given("second" + end) || values.given("output" + end);
}

/// The kind that two objects are given of. Throws InputError where it is not exactly one.
const MorphKind& kindGiven(const ModuleValues& values) {
  const MorphKind* given = nullptr;
  for (const MorphKind& kind : kMorphKinds) {
    if (!isGivenAnyOf(values, kind.ending)) continue;
    if (given)
      throw InputError(std::string("a ") + given->one + " and a " + kind.one +
                       " are given; give two objects of one kind, and an output of that kind");
    given = &kind;
  }
  if (!given) throw InputError("nothing is given to morph; give two volumes, label maps or models");
  for (const char* which : {"first", "second"})
    if (!values.given(which + std::string(given->ending)))
      throw InputError(std::string("the ") + which + " " + given->one + " is missing");
  return *given;
}

/// The folder as a prefix. Throws InputError where there is none.
std::string framesFolder(const ModuleValues& values) {
  if (!values.given("folder"))
    throw InputError("--frames " + values.text("frames") + " needs a folder for their files (--folder)");
  return values.text("folder") + "/";
}

void giveLandmarks(const ModuleValues& values, OptionSet& options) {
  const std::string &first = values.text("firstLandmarks"), &second = values.text("secondLandmarks");
  if (first.empty() && second.empty()) return;
  const std::vector<std::string> on = parted(first, ';'), to = parted(second, ';');
  if (first.empty() || second.empty() || on.size() != to.size())
    throw InputError("there are " + std::to_string(first.empty() ? 0 : on.size()) +
                     " landmarks on the first object and " + std::to_string(second.empty() ? 0 : to.size()) +
                     " on the second; the n-th of one belongs with the n-th of the other");
  std::string pairs;
  for (size_t i = 0; i < on.size(); ++i) pairs += (i ? ";" : "") + on[i] + "=" + to[i];
  options.set(options.row("landmarks"), {pairs});
}

/// The options of `slicemorph morph` for what is given; `output`: the object's file, empty if it is not wanted.
OptionSet optionsFor(const ModuleValues& values, const MorphKind& kind, const std::string& output) {
  OptionSet options(kMorph);
  const auto set = [&](const char* name, const std::vector<std::string>& texts) {
    options.set(options.row(name), texts);
  };
  values.apply(options);
  set("inputs",
      {values.text("first" + std::string(kind.ending)), values.text("second" + std::string(kind.ending))});
  if (kind.image) set("image", {kind.image});
  if (values.number("frames") > 0) {
    set("frames", {formatNumber(values.number("frames"))});
    set("output",
        {framesFolder(values) + (kind.kind == ParameterKind::kModel ? "morph.####.vtp" : "morph.####.nrrd")});
  } else {
    set("at", {values.text("time")});
    set("output", {output});
  }
  giveLandmarks(values, options);
  return options;
}

void runMorphModule(const ModuleValues& values, JobEvents& events) {
  const MorphKind& kind = kindGiven(values);
  const std::string output = values.text("output" + std::string(kind.ending));
  if (output.empty() && values.number("frames") == 0)
    throw InputError(std::string("no output: give an in-between ") + kind.one +
                     ", or a number of frames and their folder");
  const OptionSet options = optionsFor(values, kind, output);
  if (!output.empty()) checkOutputPath(output);
  checkOutputPath(options.values().output);
  const auto limit = limitThreads(options.values().threads);
  memorySettings(options).enforce();

  const double count = values.number("frames") + (output.empty() ? 0 : 1);
  const double planned = kPlanningShare / (kPlanningShare + (1 - kPlanningShare) * count);
  PartEvents planning(events, 0, planned);
  MorphSession session(options, planning);
  std::vector<FrameJob> jobs;
  if (values.number("frames") > 0) jobs = session.frames(std::nullopt);
  if (!output.empty()) jobs.push_back(session.frameAt(values.number("time"))), jobs.back().path = output;
  for (size_t i = 0; i < jobs.size(); ++i) {
    PartEvents part(events, planned + (1 - planned) * double(i) / double(jobs.size()),
                    planned + (1 - planned) * double(i + 1) / double(jobs.size()));
    part.report("making frames", 0);
    part.throwIfCancelled();
    session.save(jobs[i].path, jobs[i], session.make(jobs[i], part), part);
    events.fileWritten(jobs[i].path, false);
  }
}

}  // namespace

SlicerModule morphModule() {
  SlicerModule module;
  module.name = "SlicemorphMorph", module.title = "Morph";
  module.description =
      "Makes the in-between of two volumes, label maps, segmentations or models, at one time or as a "
      "sequence of "
      "files: both are cut into slices, contours are matched, and what lies between is rebuilt from a map "
      "without "
      "folds.";
  for (const MorphKind& kind : kMorphKinds) module.groups.push_back(groupOf(kind));
  for (ParameterGroup group : {timeGroup(), landmarkGroup(), matchingGroup(), executionGroup(kMorph)})
    module.groups.push_back(std::move(group));
  module.run = runMorphModule;
  return module;
}

}  // namespace slicemorph

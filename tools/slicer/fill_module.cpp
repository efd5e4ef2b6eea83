#include "tools/job/limit_threads.h"
#include "tools/job/option_values.h"
#include "tools/job/reconstruct.h"
#include "tools/job/write_structures.h"
#include "tools/slicer/given_group.h"
#include "tools/slicer/slicer_module.h"

namespace slicemorph {
namespace {

/// The ending of the parameters of the pair that is given: `Labels` or `Volume`. Throws InputError where it is not exactly
/// one pair.
std::string pairGiven(const ModuleValues& values) {
  const bool labels = values.given("inputLabels") || values.given("outputLabels");
  if (labels && (values.given("inputVolume") || values.given("outputVolume")))
    throw InputError("a label map and a volume are given; give the input and the output of one of them");
  const std::string end = labels ? "Labels" : "Volume", what = labels ? "label map" : "volume";
  if (!labels && !values.given("inputVolume") && !values.given("outputVolume"))
    throw InputError("nothing is given to fill; give a label map or a volume");
  if (!values.given("input" + end)) throw InputError("the " + what + " to fill is missing");
  if (!values.given("output" + end)) throw InputError("the " + what + " for the result is missing");
  return end;
}

void runFillModule(const ModuleValues& values, JobEvents& events) {
  const std::string end = pairGiven(values);
  OptionSet options(kReconstruct);
  values.apply(options);
  options.set(options.row("input"), {values.text("input" + end)});
  options.set(options.row("output"), {values.text("output" + end)});
  options.set(options.row("image"), {end == "Labels" ? "labels" : "grey"});
  const ReconstructJob job = reconstructJob(options);
  checkStudyOutput(job.output, job.source, job.names);
  const auto limit = limitThreads(options.values().threads);
  job.memory.enforce();
  events.report("filling in slices", 0);
  reconstruct(job, events);
}

}  // namespace

SlicerModule fillModule() {
  const auto labels = ParameterKind::kLabelMap, volume = ParameterKind::kVolume;
  SlicerModule module;
  module.name = "SlicemorphFillBetweenSlices", module.title = "Fill between slices";
  module.description =
      "Makes a dense label map of one that was drawn on some slices, along one axis or several, or a dense "
      "volume of one "
      "in which slices are missing: shapes and values move from slice to slice, branch and merge.";
  module.groups = {
      {"Label map or segmentation",
       "Slices without labels are filled in, also between slices of any distances.",
       false,
       {inputOf(labels, "inputLabels", "Drawn label map", "Labels on some slices, the others are empty"),
        outputOf(labels, "outputLabels", "Dense label map", "All slices", "inputLabels")}},
      {"Volume",
       "Slices that are missing in a grey volume are made of their neighbours.",
       false,
       {inputOf(volume, "inputVolume", "Volume with missing slices",
                "Missing slices hold one value all over"),
        outputOf(volume, "outputVolume", "Dense volume", "All slices", "inputVolume")}},
      givenGroup({"axis", "given", "every", "between"}),
      executionGroup(kReconstruct)};
  module.run = runFillModule;
  return module;
}

}  // namespace slicemorph

#include "tools/job/methods.h"

#include "engine/peers/peers.h"
#include "io/braces.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"
#include "tools/job/contour_methods.h"
#include "tools/job/grid_methods.h"
#include "tools/job/morph_settings.h"
#include "tools/job/option_values.h"
#include "tools/job/plan_parts.h"

#include <algorithm>
#include <stdexcept>

namespace slicemorph {
namespace {

/// Steps of OpenVDB's LevelSetMorphing before it is given up, unless others are given: enough for a surface that moves a
/// voxel per step to cross a grid of 2000 voxels.
constexpr int kLevelSetSteps = 2000;

MethodPlan planSlices(const MethodTask& task) {
  const std::vector<Object> objects = objectsOf(task);
  MethodPlan plan;
  const MorphOptions& options = task.options ? *task.options : task.settings.plan;
  if (task.decisions) {
    plan.slices = std::make_shared<MorphPlan>(
        MorphPlan::decidedBefore(objects, options, *task.decisions, &task.progress));
    plan.notes = plan.slices->notes();
  } else if (task.before && task.before->slices) {
    plan.slices = std::make_shared<MorphPlan>(objects, *task.before->slices, &task.progress);
    for (const Note& note : plan.slices->notes())
      if (note.code == "sequence.planned-anew")
        plan.notes = about("frame " + std::to_string(task.frame), {note});
  } else {
    plan.slices = std::make_shared<MorphPlan>(objects, options, &task.progress);
    plan.notes = plan.slices->notes();
  }
  plan.shape = [slices = plan.slices](const FrameJob& job) { return slices->frame(job.weights); };
  plan.pullback = [slices = plan.slices](const Weights& weights) { return slices->pullback(weights); };
  return plan;
}

MethodPlan planSdf(const MethodTask& task) {
  return planOf(std::make_shared<const SdfBlend>(gridsOf(task), commonVoxelSize(task)));
}

MethodPlan planLevelSet(const MethodTask& task) {
  const auto result = std::make_shared<LevelSetMorphResult>(
      levelSetMorph(*task.inputs[0].object.levelSet, *task.inputs[1].object.levelSet,
                    int(task.settings.frames.size()), int(task.parameter("steps")), &task.progress));
  MethodPlan plan;
  plan.shape = [result, first = task.settings.frames[0].number](const FrameJob& job) {
    return InBetween{result->frames[size_t(job.number - first)], 0};
  };
  plan.restDistance = result->restDistance;
  plan.notes.emplace_back("levelset.came-to-rest", Severity::kNote, "",
                          "the level set came to rest after " + std::to_string(result->steps) +
                              " steps, at most " + formatNumber(result->restDistance, 3) + " voxels from " +
                              task.settings.inputs[1]);
  return plan;
}

MethodPlan planDissolve(const MethodTask&) {
  return {[](const FrameJob&) { return InBetween(); },
          [](const Weights& weights) { return dissolve(weights); }};
}

std::vector<MorphMethod> makeTable() {
  std::vector<MorphMethod> table;
  MethodTraits slices;
  slices.grids = slices.colors = slices.images = slices.guided = slices.features = true;
  table.push_back({"slices", "matches the contours of oriented slices and moves them", slices, planSlices});

  table.push_back({"sdf", "blends distances point by point", MethodTraits(), planSdf});

  MethodTraits levelSet;
  levelSet.anyTime = false, levelSet.mostInputs = 2;
  table.push_back({"levelset",
                   "moves the surface to the nearest",
                   levelSet,
                   planLevelSet,
                   {{"steps", "steps after which a surface that still moves is left where it is", "",
                     kLevelSetSteps, 1, 1e6, true}}});

  MethodTraits values;
  values.surface = false, values.grids = values.images = true;
  table.push_back({"dissolve", "blends values where they are", values, planDissolve});

  addContourMethods(table);
  addGridMethods(table);
  return table;
}

}  // namespace

const std::vector<MorphMethod>& morphMethods() {
  static const std::vector<MorphMethod> table = makeTable();
  return table;
}

const MorphMethod& methodNamed(const std::string& name) {
  std::string known;
  for (const MorphMethod& method : morphMethods()) {
    if (method.name == name) return method;
    known += (known.empty() ? "" : ", ") + method.name;
  }
  throw InputError("--method " + name + ": there is no such method; there are " + known);
}

MethodChoice methodChoice(const std::string& text) {
  const BracedText split = splitBraces(text);
  const MorphMethod& method = methodNamed(split.name);
  return {method.name, parsedParameters("--method " + text, method.parameters, split)};
}

double MethodTask::parameter(const std::string& name) const {
  const std::vector<MethodParameter>& all = methodNamed(settings.method).parameters;
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const MethodParameter& p) { return p.name == name; });
  if (found == all.end()) throw std::logic_error(settings.method + " has no parameter " + name);
  return valueOf(*found, settings.parameters);
}

std::vector<std::string> methodNames() {
  std::vector<std::string> names;
  for (const MorphMethod& method : morphMethods()) names.push_back(method.name);
  return names;
}

std::string methodHelp() {
  const std::vector<MorphMethod>& methods = morphMethods();
  std::string help = methods[0].name + "; or a classic: ";
  for (size_t i = 1; i < methods.size(); ++i)
    help += (i > 1 ? ", " : "") + methods[i].name + " " + methods[i].help;
  return help;
}

std::string describeMethod(const MorphMethod& method) {
  std::string text = method.help;
  for (size_t i = 0; i < method.parameters.size(); ++i)
    text += (i ? "; " : ". Parameters: ") + describeParameter(method.parameters[i]);
  return text;
}

std::string methodsThat(bool MethodTraits::*can) {
  std::string names;
  for (const MorphMethod& method : morphMethods())
    if (method.can.*can) names += (names.empty() ? "" : " or ") + method.name;
  return "--method " + names;
}

}  // namespace slicemorph

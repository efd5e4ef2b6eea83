#include "tools/job/methods.h"

#include "engine/peers/peers.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"
#include "tools/job/morph_settings.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <limits>

namespace slicemorph {
namespace {

/// Most steps of OpenVDB's LevelSetMorphing before it is given up: enough for a surface that moves a voxel
/// per step to cross a grid of 2000 voxels.
constexpr int kMostLevelSetSteps = 2000;

MethodPlan planSlices(const MethodTask& task) {
  std::vector<Object> objects;
  for (const LoadedObject& input : task.inputs) objects.push_back(input.object);
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
  std::vector<FloatGrid::ConstPtr> grids;
  double finest = std::numeric_limits<double>::max();
  for (const LoadedObject& input : task.inputs) {
    grids.push_back(input.object.levelSet);
    finest = std::min(finest, grids.back()->voxelSize()[0]);
  }
  const double voxelSize = task.settings.plan.voxelSize > 0 ? task.settings.plan.voxelSize : finest;
  const auto blend = std::make_shared<SdfBlend>(grids, voxelSize);
  return {[blend](const FrameJob& job) { return InBetween{blend->frame(job.weights), 0}; }};
}

MethodPlan planLevelSet(const MethodTask& task) {
  const auto result = std::make_shared<LevelSetMorphResult>(
      levelSetMorph(*task.inputs[0].object.levelSet, *task.inputs[1].object.levelSet,
                    int(task.settings.frames.size()), kMostLevelSetSteps, &task.progress));
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
  slices.grids = slices.colors = slices.images = slices.guided = true;
  table.push_back({"slices", "matches the contours of oriented slices and moves them", slices, planSlices});

  table.push_back({"sdf", "blends distances point by point", MethodTraits(), planSdf});

  MethodTraits levelSet;
  levelSet.anyTime = false, levelSet.mostInputs = 2;
  table.push_back({"levelset", "moves the surface to the nearest", levelSet, planLevelSet});

  MethodTraits values;
  values.surface = false, values.grids = values.images = true;
  table.push_back({"dissolve", "blends values where they are", values, planDissolve});
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

std::string methodsThat(bool MethodTraits::*can) {
  std::string names;
  for (const MorphMethod& method : morphMethods())
    if (method.can.*can) names += (names.empty() ? "" : " or ") + method.name;
  return "--method " + names;
}

}  // namespace slicemorph

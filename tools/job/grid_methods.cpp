#include "tools/job/grid_methods.h"

#include "engine/peers/minkowski.h"
#include "engine/peers/morphology.h"
#include "tools/job/plan_parts.h"

namespace slicemorph {
namespace {

MethodPlan planMorphology(const MethodTask& task) {
  return planOf(
      std::make_shared<const MorphologyMorph>(gridsOf(task), commonVoxelSize(task), &task.progress));
}

MethodPlan planMinkowski(const MethodTask& task) {
  MinkowskiOptions options;
  options.directions = int(task.parameter("directions"));
  return planOf(
      std::make_shared<const MinkowskiMorph>(gridsOf(task), commonVoxelSize(task), options, &task.progress));
}

}  // namespace

void addGridMethods(std::vector<MorphMethod>& table) {
  const MethodTraits surface;
  table.push_back({"morphology", "dilates and erodes what objects have beside their common part", surface,
                   planMorphology});
  table.push_back({"minkowski",
                   "adds weighted objects point by point (others than convex ones in a box of 2.1 million "
                   "voxels at most)",
                   surface,
                   planMinkowski,
                   {{"directions", "directions per right angle in which convex objects are measured", "", 32,
                     4, 256, true}}});
}

}  // namespace slicemorph

#include "tools/job/grid_methods.h"

#include "engine/peers/morphology.h"
#include "tools/job/plan_parts.h"

namespace slicemorph {
namespace {

MethodPlan planMorphology(const MethodTask& task) {
  return planOf(
      std::make_shared<const MorphologyMorph>(gridsOf(task), commonVoxelSize(task), &task.progress));
}

}  // namespace

void addGridMethods(std::vector<MorphMethod>& table) {
  const MethodTraits surface;
  table.push_back({"morphology", "dilates and erodes what objects have beside their common part", surface,
                   planMorphology});
}

}  // namespace slicemorph

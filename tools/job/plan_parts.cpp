#include "tools/job/plan_parts.h"

#include <algorithm>

namespace slicemorph {

double commonVoxelSize(const MethodTask& task) {
  if (task.settings.plan.voxelSize > 0) return task.settings.plan.voxelSize;
  double finest = task.inputs[0].object.levelSet->voxelSize()[0];
  for (const LoadedObject& input : task.inputs)
    finest = std::min(finest, input.object.levelSet->voxelSize()[0]);
  return finest;
}

std::vector<Object> objectsOf(const MethodTask& task) {
  std::vector<Object> objects;
  for (const LoadedObject& input : task.inputs) objects.push_back(input.object);
  return objects;
}

std::vector<FloatGrid::ConstPtr> gridsOf(const MethodTask& task) {
  std::vector<FloatGrid::ConstPtr> grids;
  for (const LoadedObject& input : task.inputs) grids.push_back(input.object.levelSet);
  return grids;
}

}  // namespace slicemorph

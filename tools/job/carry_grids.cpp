#include "tools/job/carry_grids.h"

#include "engine/rebuild/add_vectors.h"
#include "engine/volume/fog.h"
#include "io/vdb/grid_choice.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <set>

namespace slicemorph {
namespace {

using openvdb::GridBase;

/// Names that Houdini, Blender and other programs give to velocity grids.
const std::set<std::string> kVelocityNames{"vel", "v", "velocity"};

/// The voxel size that the options ask for, world units; 0: grids keep their own.
double voxelSizeOf(const FrameTask& task) {
  if (task.settings.plan.voxelSize > 0) return task.settings.plan.voxelSize;
  if (task.settings.load.resolution == 0) return 0;
  double size = 0;
  const Weights weights = withoutNegatives(task.job.weights);
  for (size_t k = 0; k < task.inputs.size(); ++k)
    size += weights[k] * task.inputs[k].object.levelSet->voxelSize()[0];
  return size;
}

/// The in-between of the fog that the shapes were found in; inputs that are solids become fog with
/// a soft rim.
GridBase::ConstPtr densityOf(const FrameTask& task, Pullback& pullback, double voxelSize) {
  const GridSet& set = task.plan.content.sets[*task.plan.content.shapeSet];
  std::vector<GridBase::ConstPtr> grids = readGrids(set, task.inputs);
  const auto first = std::find_if(grids.begin(), grids.end(), [](const auto& grid) { return bool(grid); });
  const GridBase::ConstPtr prototype = first == grids.end() ? nullptr : *first;
  for (size_t k = 0; k < grids.size(); ++k) {
    if (!grids[k]) {
      const FloatGrid::Ptr fog = fogOf(*task.inputs[k].object.levelSet);
      fog->setName(set.name);
      fog->setSaveFloatAsHalf(!prototype || prototype->saveFloatAsHalf());
      grids[k] = fog;
    }
    if (prototype && grids[k]->type() != prototype->type())
      grids[k] = asFloatGrid(openvdb::ConstPtrCast<GridBase>(grids[k]));
  }
  return pullback.carry(grids, {task.settings.conserve, voxelSize});
}

/// The morph's velocities on the voxels of `where`, named as the options say, or NAME_morph where the inputs'
/// own velocities have that name and are not added.
GridBase::Ptr velocityOf(const FrameTask& task, const Pullback& pullback, const GridBase& where,
                         const openvdb::GridCPtrVec& grids) {
  const VelocitySettings& v = task.settings.velocity;
  const double framesPerSecond = task.settings.framesPerSecond;
  const openvdb::Vec3SGrid::Ptr velocity =
      pullback.velocity(where, task.job.rate, kShutter / framesPerSecond);
  velocity->setName(v.name);
  for (const GridBase::ConstPtr& grid : grids) {
    const bool isOwn = kVelocityNames.count(grid->getName()) || grid->getName() == v.name;
    if (v.add && isOwn) {
      addVectors(*velocity, *grid, 1);
      break;
    }
    if (grid->getName() == v.name) velocity->setName(v.name + "_morph");
  }
  const double unit = v.perFrame ? 1 / framesPerSecond : 1;
  if (unit != 1)
    for (auto value = velocity->beginValueOn(); value; ++value) value.setValue(*value * float(unit));
  velocity->insertMeta("velocity_unit", openvdb::StringMetadata(v.perFrame ? "frame" : "second"));
  velocity->insertMeta("fps", openvdb::FloatMetadata(float(framesPerSecond)));
  return velocity;
}

/// Appends a grid, after removing any of the same name.
void addOrReplace(openvdb::GridCPtrVec& grids, const GridBase::ConstPtr& grid) {
  const auto replaced = std::remove_if(
      grids.begin(), grids.end(), [&](const auto& other) { return other->getName() == grid->getName(); });
  grids.erase(replaced, grids.end());
  grids.push_back(grid);
}

}  // namespace

CarriedGrids carryGrids(const FrameTask& task, GridBase::ConstPtr where, openvdb::GridCPtrVec grids,
                        bool half, const Progress& cancel) {
  const FrameContent& content = task.plan.content;
  CarriedGrids carried{std::move(grids), nullptr};
  Pullback pullback = task.plan.method.pullback(task.job.weights);
  const double voxelSize = voxelSizeOf(task);
  for (size_t s = 0; s < content.sets.size(); ++s) {
    if (cancel.cancelled()) throw Cancelled();
    const bool fog = content.shapeSet == s;
    const GridBase::ConstPtr grid =
        fog ? densityOf(task, pullback, voxelSize)
            : pullback.carry(readGrids(content.sets[s], task.inputs), {false, voxelSize});
    if (fog || !where) where = grid;
    if (fog) carried.density = grid;
    carried.grids.push_back(grid);
  }
  if (!task.settings.velocity.wanted() || task.job.rate.empty() || !where) return carried;
  const GridBase::Ptr velocity = velocityOf(task, pullback, *where, carried.grids);
  velocity->setSaveFloatAsHalf(half);
  addOrReplace(carried.grids, velocity);
  return carried;
}

}  // namespace slicemorph

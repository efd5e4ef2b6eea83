#include "tools/job/carry_grids.h"

#include "engine/rebuild/add_vectors.h"
#include "engine/rebuild/velocity_grid.h"
#include "engine/volume/fog.h"
#include "io/vdb/grid_choice.h"
#include "io/vdb/vector_parts.h"
#include "slicemorph/errors.h"
#include "tools/job/own_velocity.h"

#include <openvdb/tools/Activate.h>

#include <algorithm>

namespace slicemorph {
namespace {

using openvdb::GridBase;

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

/// Fog of which nothing is there yet, or any more.
FloatGrid::Ptr noFog(const FloatGrid& levelSet) {
  const FloatGrid::Ptr fog = FloatGrid::create(0.f);
  fog->setTransform(levelSet.transform().copy());
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  return fog;
}

/// The grid with values of the prototype's type, float or double.
GridBase::ConstPtr asTypeOf(const GridBase& prototype, const GridBase::ConstPtr& grid) {
  if (prototype.type() == grid->type()) return grid;
  const FloatGrid::ConstPtr floats = asFloatGrid(openvdb::ConstPtrCast<GridBase>(grid));
  if (!prototype.isType<openvdb::DoubleGrid>()) return floats;
  const openvdb::DoubleGrid::Ptr doubles(new openvdb::DoubleGrid(*floats));
  doubles->setSaveFloatAsHalf(grid->saveFloatAsHalf());
  return doubles;
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
      const FloatGrid& levelSet = *task.inputs[k].object.levelSet;
      const FloatGrid::Ptr fog = task.inputs[k].nothing ? noFog(levelSet) : fogOf(levelSet);
      fog->setName(set.name);
      fog->setSaveFloatAsHalf(!prototype || prototype->saveFloatAsHalf());
      grids[k] = fog;
    }
    if (prototype) grids[k] = asTypeOf(*prototype, grids[k]);
  }
  return pullback.carry(grids, {task.settings.conserve, voxelSize, true});
}

/// The inputs' own velocities at a frame.
struct OwnVelocity {
  GridBase::ConstPtr grid;         ///< null: there are none
  std::vector<std::string> parts;  ///< names of their components, where these are grids of their own
};

bool isNameTaken(const FrameContent& content, const std::string& name) {
  return std::any_of(content.sets.begin(), content.sets.end(),
                     [&](const GridSet& set) { return set.name == name; });
}

double smallestVoxel(const GridBase& grid) {
  const Vec3d size = grid.voxelSize();
  return std::min({size[0], size[1], size[2]});
}

/// The morph's velocities around the active voxels of `where`, named as the options say, or NAME_morph where the inputs'
/// own velocities have that name and are not added.
openvdb::Vec3SGrid::Ptr velocityOf(const FrameTask& task, const Pullback& pullback, const GridBase& where,
                                   const OwnVelocity& own) {
  const VelocitySettings& v = task.settings.velocity;
  const double framesPerSecond = task.settings.framesPerSecond;
  // What is added has details of its own, for which the voxels must be fine.
  const bool added = own.grid && v.add;
  const double voxel = smallestVoxel(where);
  openvdb::Vec3SGrid::Ptr velocity =
      pullback.velocity(where, task.job.rate,
                        {kShutter / framesPerSecond, added ? 0 : kVelocityError * voxel * framesPerSecond});
  velocity->setName(v.name);
  if (added) {
    velocity->tree().topologyUnion(*activeVoxels(where));
    addVectors(*velocity, *own.grid, 1);
    openvdb::tools::deactivate(velocity->tree(), openvdb::Vec3s(0.f));
  } else if (isNameTaken(task.plan.content, v.name)) {
    velocity->setName(v.name + "_morph");
  }
  const double unit = v.perFrame ? 1 / framesPerSecond : 1;
  if (unit != 1)
    for (auto value = velocity->beginValueOn(); value; ++value) value.setValue(*value * float(unit));
  velocity->insertMeta("velocity_unit", openvdb::StringMetadata(v.perFrame ? "frame" : "second"));
  velocity->insertMeta("fps", openvdb::FloatMetadata(float(framesPerSecond)));
  return velocity;
}

using Comparable =
    openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                      openvdb::BoolGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>;

/// Whether two grids are the same voxel by voxel: of two files of a simulation what stands still.
bool standsStill(const std::vector<GridBase::ConstPtr>& grids) {
  const GridBase::ConstPtr &a = grids[0], &b = grids[1];
  if (!a || !b || a->type() != b->type() || a->transform() != b->transform()) return false;
  bool same = false;
  a->apply<Comparable>([&](const auto& typed) {
    using Grid = std::decay_t<decltype(typed)>;
    const Grid& other = static_cast<const Grid&>(*b);
    same = typed.tree().hasSameTopology(other.tree());
    for (auto u = typed.cbeginValueOn(), v = other.cbeginValueOn(); same && u; ++u, ++v) same = *u == *v;
  });
  return same;
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
  OwnVelocity own;
  for (size_t s = 0; s < content.sets.size(); ++s) {
    if (cancel.cancelled()) throw Cancelled();
    const bool fog = content.shapeSet == s;
    GridBase::ConstPtr grid;
    if (fog) {
      grid = densityOf(task, pullback, voxelSize);
    } else {
      const std::vector<GridBase::ConstPtr> of = readGrids(content.sets[s], task.inputs);
      grid = task.settings.eachAlone && standsStill(of) ? of[0] : pullback.carry(of, {false, voxelSize});
    }
    if (fog || !where) where = grid;
    if (fog) carried.density = grid;
    const GridSet& set = content.sets[s];
    if (!fog && isOwnVelocity(set, *grid, task.settings.velocity)) {
      grid = scaledVectors(grid, task.job.speed);
      if (!own.grid) own = {grid, set.parts};
    }
    if (set.parts.empty()) {
      carried.grids.push_back(grid);
    } else {
      for (const GridBase::Ptr& part : splitParts(*grid, set.parts)) carried.grids.push_back(part);
    }
  }
  const VelocitySettings& v = task.settings.velocity;
  if (!v.wanted() || task.job.rate.empty() || !where || (v.onlyIfNone && own.grid)) return carried;
  const openvdb::Vec3SGrid::Ptr velocity = velocityOf(task, pullback, *where, own);
  velocity->setSaveFloatAsHalf(half || v.half);
  addOrReplace(carried.grids, velocity);
  // Where programs look the components up they find the same as in the vectors.
  if (v.add && !own.parts.empty())
    for (const GridBase::Ptr& part : splitParts(*velocity, own.parts)) addOrReplace(carried.grids, part);
  return carried;
}

openvdb::Vec3SGrid::ConstPtr velocityAround(const FrameTask& task, const GridBase& where) {
  if (!task.settings.velocity.wanted() || task.job.rate.empty() || !task.plan.method.pullback) return nullptr;
  const Pullback pullback = task.plan.method.pullback(task.job.weights);
  return velocityOf(task, pullback, where, {});
}

}  // namespace slicemorph

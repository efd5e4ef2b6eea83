#include "engine/peers/full_fields.h"

#include "engine/peers/require.h"
#include "engine/rebuild/sweep_band.h"
#include "engine/volume/distance_field.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <memory>
#include <string>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatTree;
using openvdb::math::Transform;
using Leaf = FloatTree::LeafNodeType;

/// Box of all narrow bands, in voxels of `transform`, rounded to whole leaves.
CoordBBox commonBox(const std::vector<FloatGrid::ConstPtr>& levelSets, const Transform& transform) {
  CoordBBox box;
  for (const auto& grid : levelSets) {
    const openvdb::BBoxd world = grid->transform().indexToWorld(grid->evalActiveVoxelBoundingBox());
    box.expand(transform.worldToIndexCellCentered(world.min()));
    box.expand(transform.worldToIndexCellCentered(world.max()));
  }
  const int mask = ~(int(Leaf::DIM) - 1);
  return CoordBBox(box.min() & mask, (box.max() & mask).offsetBy(Leaf::DIM - 1));
}

std::vector<Coord> leafOrigins(const CoordBBox& box) {
  std::vector<Coord> origins;
  const int step = Leaf::DIM;
  for (int x = box.min().x(); x <= box.max().x(); x += step)
    for (int y = box.min().y(); y <= box.max().y(); y += step)
      for (int z = box.min().z(); z <= box.max().z(); z += step) origins.emplace_back(x, y, z);
  return origins;
}

/// The distance to a level set's surface at every voxel of the given leaves.
FloatGrid::Ptr fullField(FloatGrid::ConstPtr levelSet, const Transform& transform,
                         const std::vector<Coord>& origins) {
  const DistanceField distance(levelSet);
  std::vector<Leaf*> leaves(origins.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, origins.size()), [&](const auto& range) {
    DistanceField::Sampler sample(distance);
    for (size_t i = range.begin(); i != range.end(); ++i) {
      leaves[i] = new Leaf(origins[i], 0.0f, true);
      for (openvdb::Index n = 0; n < Leaf::SIZE; ++n)
        leaves[i]->setValueOnly(
            n, sample(distance.relative(transform.indexToWorld(leaves[i]->offsetToGlobalCoord(n)))));
    }
  });
  auto field = FloatGrid::create();
  field->setTransform(transform.copy());
  for (Leaf* leaf : leaves) field->tree().addLeaf(leaf);
  return field;
}

/// Activates the voxels within the band and clamps all others. Returns whether any voxel is active.
bool clampToBand(Leaf& leaf, float band) {
  float* values = leaf.buffer().data();
  for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
    const bool near = std::abs(values[i]) < band;
    if (!near) values[i] = std::copysign(band, values[i]);
    leaf.setActiveState(i, near);
  }
  return !leaf.isEmpty();
}

}  // namespace

void reportOrCancel(Progress* progress, const char* stage, double fraction) {
  if (!progress) return;
  if (progress->cancelled()) throw Cancelled();
  progress->report(stage, fraction);
}

FullFields::FullFields(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                       const char* method, Progress* progress)
    : inputs_(levelSets.size()), transform_(Transform::createLinearTransform(voxelSize)) {
  const CoordBBox box = commonBox(levelSets, *transform_);
  if (box.volume() > (openvdb::Index64(1) << 31))
    throw InputError("--method " + std::string(method) +
                     " needs every voxel of the box about all inputs, which are " +
                     std::to_string(box.volume()) +
                     " here; 2147483648 at most: choose a larger --voxel-size or a "
                     "smaller --resolution");
  origins_ = leafOrigins(box);
  for (size_t k = 0; k < levelSets.size(); ++k) {
    reportOrCancel(progress, "measuring distances", double(k) / double(levelSets.size()));
    add(levelSets[k]);
  }
}

void FullFields::add(const FloatGrid::ConstPtr& levelSet) {
  fields_.push_back(fullField(levelSet, *transform_, origins_));
}

void FullFields::requireWeights(const Weights& weights) const {
  slicemorph::requireWeights(weights, inputs_);
}

FloatGrid::Ptr FullFields::levelSetOf(const LeafFunction& function, double steepest) const {
  const float band = float(kHalfWidth * transform_->voxelSize()[0]);
  std::vector<std::vector<const Leaf*>> leaves(fields_.size());
  for (size_t k = 0; k < fields_.size(); ++k) fields_[k]->tree().getNodes(leaves[k]);

  // Only leaves with voxels of the band are kept; flood fill restores the sign of the others.
  std::vector<std::unique_ptr<Leaf>> near(leaves[0].size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, near.size()), [&](const auto& range) {
    std::vector<const float*> distances(fields_.size());
    for (size_t i = range.begin(); i != range.end(); ++i) {
      for (size_t k = 0; k < fields_.size(); ++k) distances[k] = leaves[k][i]->buffer().data();
      auto leaf = std::make_unique<Leaf>(leaves[0][i]->origin());
      function(distances, leaf->buffer().data());
      if (clampToBand(*leaf, float(steepest) * band)) near[i] = std::move(leaf);
    }
  });
  auto surface = FloatGrid::create(float(steepest) * band);
  surface->setTransform(transform_->copy());
  for (auto& leaf : near)
    if (leaf) surface->tree().addLeaf(leaf.release());
  openvdb::tools::signedFloodFill(surface->tree());
  // A function of distances is not a distance.
  return sweptLevelSet(*surface, band);
}

}  // namespace slicemorph

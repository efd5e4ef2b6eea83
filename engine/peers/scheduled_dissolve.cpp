#include "engine/peers/scheduled_dissolve.h"

#include "engine/peers/full_fields.h"
#include "engine/peers/function_level_set.h"
#include "engine/peers/require.h"
#include "engine/reconstruct/lattice_level_set.h"
#include "engine/volume/distance_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace slicemorph {
namespace {

/// A lattice about all level sets, with a node at the world's origin or in line with it.
Lattice latticeAbout(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                     const LatticeTransform& transform, const char* method) {
  openvdb::BBoxd box;
  for (const auto& levelSet : levelSets)
    box.expand(levelSet->transform().indexToWorld(levelSet->evalActiveVoxelBoundingBox()));
  const Vec3d margin = box.extents() / 16.0 + Vec3d(4 * voxelSize);
  const Vec3d low = (box.min() - margin) / voxelSize, high = (box.max() + margin) / voxelSize;
  const Vec3d extent = high - low;
  const double nodes = extent[0] * extent[1] * extent[2];
  requireAtMost(
      "--method " + std::string(method) + " needs every voxel of a box about all inputs, which are ", nodes,
      ScheduledDissolve::kMostNodes);
  Lattice lattice;
  lattice.spacing = voxelSize;
  const openvdb::Coord first = openvdb::Coord::floor(low), last = openvdb::Coord::ceil(high);
  lattice.origin = voxelSize * first.asVec3d();
  for (int a = 0; a < 3; ++a) lattice.size[a] = transform.nodes(last[a] - first[a] + 1);
  return lattice;
}

std::vector<float> distancesOnLattice(const FloatGrid::ConstPtr& levelSet, const Lattice& lattice) {
  const DistanceField field(levelSet);
  std::vector<float> values(lattice.count());
  tbb::parallel_for(0, lattice.size[2], [&](int z) {
    const DistanceField::Sampler sample(field);
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x)
        values[lattice.index(x, y, z)] = sample(field.relative(lattice.position(x, y, z)));
  });
  return values;
}

}  // namespace

double scheduledShare(double weight, double fineness, double fade) {
  const double whole = 1 + (fade - 1) * fineness * fineness;
  if (whole <= 0) return weight < 1 ? std::min(weight, 0.0) : 1;
  return std::max(std::min(weight, 0.0), 1 - (1 - weight) / whole);
}

ScheduledDissolve::ScheduledDissolve(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                                     double fade, std::unique_ptr<LatticeTransform> transform,
                                     const char* method, Progress* progress)
    : lattice_(latticeAbout(levelSets, voxelSize, *transform, method)),
      fade_(fade),
      transform_(std::move(transform)) {
  for (size_t k = 0; k < levelSets.size(); ++k) {
    reportOrCancel(progress, "measuring distances", double(k) / double(levelSets.size()));
    parts_.push_back(distancesOnLattice(levelSets[k], lattice_));
    reportOrCancel(progress, "transforming distances", (double(k) + 0.5) / double(levelSets.size()));
    transform_->forward(lattice_, parts_[k]);
  }
}

FloatGrid::Ptr ScheduledDissolve::frame(const Weights& weights) const {
  requireWeights(weights, parts_.size());
  std::vector<float> blend(lattice_.count());
  tbb::parallel_for(0, lattice_.size[2], [&](int z) {
    for (int y = 0; y < lattice_.size[1]; ++y)
      for (int x = 0; x < lattice_.size[0]; ++x) {
        const double fineness = transform_->fineness(lattice_, {x, y, z});
        const size_t n = lattice_.index(x, y, z);
        double sum = 0;
        for (size_t k = 0; k < weights.size(); ++k)
          sum += scheduledShare(weights[k], fineness, fade_) * double(parts_[k][n]);
        blend[n] = float(sum);
      }
  });
  transform_->inverse(lattice_, blend);
  const bool any = std::any_of(blend.begin(), blend.end(), [](float value) { return value < 0; });
  return any ? latticeLevelSet(lattice_, std::move(blend)) : emptyLevelSet(lattice_.spacing);
}

}  // namespace slicemorph

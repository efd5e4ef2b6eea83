#include "engine/rebuild/in_between.h"

#include "engine/rebuild/rebuild.h"

#include <utility>

namespace slicemorph {

namespace {

/// Voxels between map nodes, 4 or 8. Finer than any detail of the matching, whose finest fields have nodes
/// 0.04 of the objects' size apart (16 voxels of 400), and coarse enough to be cheap.
int nodeStepOf(const Chart& chart, double halfLength, double voxelSize) {
  const double voxels = 2 * halfLength * chart.scale[0] / voxelSize;
  return voxels > 400 ? 8 : 4;
}

}  // namespace

RebuiltShape rebuildInBetween(const MorphParts& parts, const Weights& weights,
                              std::shared_ptr<const MovingLattice::Pose> pose, double voxelSize) {
  const openvdb::math::Transform::ConstPtr transform =
      openvdb::math::Transform::createLinearTransform(voxelSize);
  const int step = nodeStepOf(pose->chart, parts.frames.halfLength, voxelSize);
  NodeMap nodes = parts.lattice.nodesNearSurface(*pose, *transform, step);
  DistanceBlend blend{parts.lattice.localWeights(weights), {}, pose->chart.meanScale()};
  for (const Chart& chart : parts.frames.charts) blend.sizes.push_back(chart.meanScale());
  InBetween shape{rebuildLevelSet(nodes, parts.fields, blend, *transform), nodes.foldShare};
  return {std::move(shape),
          std::make_shared<const SurfaceMap>(SurfaceMap{std::move(pose), transform, std::move(nodes)})};
}

}  // namespace slicemorph

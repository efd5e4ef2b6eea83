#include "engine/rebuild/sweep_band.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/Prune.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace slicemorph {
namespace {

/// Activates the voxels within the band and clamps all others to it.
FloatGrid::Ptr trimmed(const FloatGrid::Ptr& swept, const openvdb::math::Transform& transform, float band) {
  FloatGrid::Ptr result = swept;
  if (!result) {
    result = FloatGrid::create(band);
    result->setTransform(transform.copy());
  }
  // The sweep has set the background to the largest distance it met.
  openvdb::tools::changeLevelSetBackground(result->tree(), band);
  using Leaf = openvdb::FloatTree::LeafNodeType;
  std::vector<Leaf*> leaves;
  result->tree().getNodes(leaves);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, leaves.size()), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      float* values = leaves[i]->buffer().data();
      for (openvdb::Index n = 0; n < Leaf::SIZE; ++n) {
        const bool near = std::abs(values[n]) < band;
        if (!near) values[n] = std::copysign(band, values[n]);
        leaves[i]->setActiveState(n, near);
      }
    }
  });
  openvdb::tools::pruneLevelSet(result->tree());
  result->setName("surface");
  result->setGridClass(openvdb::GRID_LEVEL_SET);
  return result;
}

}  // namespace

FloatGrid::Ptr sweptLevelSet(const FloatGrid& field, float band) {
  return trimmed(openvdb::tools::sdfToSdf(field), field.transform(), band);
}

FloatGrid::Ptr widenedLevelSet(const FloatGrid& levelSet, int voxels, float band) {
  // Dilated across edges and corners, too: across faces alone, a band that faces a diagonal would grow by
  // only 1 / sqrt 3 of a voxel per step.
  const auto wide = openvdb::tools::dilateSdf(levelSet, voxels, openvdb::tools::NN_FACE_EDGE_VERTEX);
  return trimmed(wide, levelSet.transform(), band);
}

}  // namespace slicemorph

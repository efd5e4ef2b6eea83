#include "engine/measure/matching_grid.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatTree;
using openvdb::math::Transform;
using Leaf = FloatTree::LeafNodeType;

/// Index box in `to` that covers an index box of `from`, with a margin of one voxel.
CoordBBox mapBox(const CoordBBox& box, const Transform& from, const Transform& to) {
  const openvdb::BBoxd world = from.indexToWorld(box);
  const Vec3d corners[2] = {to.worldToIndex(world.min()), to.worldToIndex(world.max())};
  CoordBBox mapped;
  for (const Vec3d& c : corners) mapped.expand(Coord::floor(c)), mapped.expand(Coord::ceil(c));
  mapped.expand(1);
  return mapped;
}

void touchLeaves(FloatTree& tree, const CoordBBox& box) {
  const Coord first = box.min() & ~(int(Leaf::DIM) - 1);
  for (int x = first.x(); x <= box.max().x(); x += Leaf::DIM)
    for (int y = first.y(); y <= box.max().y(); y += Leaf::DIM)
      for (int z = first.z(); z <= box.max().z(); z += Leaf::DIM) tree.touchLeaf(Coord(x, y, z));
}

void sampleLeaf(Leaf& leaf, const Transform& transform, const FloatGrid& source, float background) {
  auto accessor = source.getConstAccessor();
  for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
    const Vec3d world = transform.indexToWorld(leaf.offsetToGlobalCoord(i));
    const float value = openvdb::tools::BoxSampler::sample(accessor, source.transform().worldToIndex(world));
    if (std::abs(value) < background)
      leaf.setValueOn(i, value);
    else
      leaf.setValueOff(i, std::copysign(background, value));
  }
}

}  // namespace

FloatGrid::Ptr sampleOnto(const FloatGrid& levelSet, const Transform& transform) {
  const float background = levelSet.background();
  auto result = FloatGrid::create(background);
  result->setTransform(transform.copy());
  result->setGridClass(openvdb::GRID_LEVEL_SET);
  for (auto leaf = levelSet.tree().cbeginLeaf(); leaf; ++leaf)
    touchLeaves(result->tree(), mapBox(leaf->getNodeBoundingBox(), levelSet.transform(), transform));
  std::vector<Leaf*> leaves;
  result->tree().getNodes(leaves);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, leaves.size()), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i)
      sampleLeaf(*leaves[i], transform, levelSet, background);
  });
  openvdb::tools::signedFloodFill(result->tree());
  return result;
}

}  // namespace slicemorph

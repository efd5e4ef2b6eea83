#include "engine/rebuild/add_vectors.h"

#include "slicemorph/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tree/LeafManager.h>

namespace slicemorph {

void addVectors(openvdb::Vec3SGrid& to, const openvdb::GridBase& from, double factor) {
  using Types = openvdb::TypeList<openvdb::Vec3SGrid, openvdb::Vec3DGrid>;
  const bool known = from.apply<Types>([&](const auto& grid) {
    using Value = typename std::decay_t<decltype(grid)>::ValueType;
    const bool staggered = grid.getGridClass() == openvdb::GRID_STAGGERED;
    openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(to.tree());
    leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, size_t) {
      const auto accessor = grid.getConstAccessor();
      for (auto v = leaf.beginValueOn(); v; ++v) {
        const Vec3d at = grid.transform().worldToIndex(to.transform().indexToWorld(v.getCoord()));
        Value value;
        if (staggered)
          openvdb::tools::StaggeredBoxSampler::sample(accessor, at, value);
        else
          openvdb::tools::BoxSampler::sample(accessor, at, value);
        v.setValue(*v + openvdb::Vec3s(factor * Vec3d(value)));
      }
    });
  });
  if (!known)
    throw InputError("grid '" + from.getName() + "' holds " + from.valueType() + " values, no velocities");
}

}  // namespace slicemorph

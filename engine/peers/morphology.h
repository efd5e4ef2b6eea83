#pragma once

#include "engine/peers/full_fields.h"

namespace slicemorph {

/// Morph by mathematical morphology: what an object has beside the part that all have in common is eroded down to that
/// part as its weight falls, and dilated out of it as its weight rises. The in-between is the union of these. Instead of
/// repeated steps by a voxel, the distances from the object's surface and from the common part tell when a point is
/// passed, as in interpolation by Hausdorff distances [Ser98]: points at distance u inside the object's surface and v
/// outside the common part belong to it while weight * u >= (1 - weight) * v.
class MorphologyMorph {
 public:
  /// Throws InputError where the objects have no voxel in common, and where the box about them has more than 2^31 voxels;
  /// Cancelled. Keeps all voxels of that box once for each object and once more.
  MorphologyMorph(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                  Progress* progress = nullptr);
  /// A level set named "surface". Throws InputError unless there is one weight per level set.
  FloatGrid::Ptr frame(const Weights& weights) const;

 private:
  FullFields fields_;  ///< of the objects; the last one of their common part
};

}  // namespace slicemorph

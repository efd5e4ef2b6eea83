#pragma once

#include "engine/volume/small_components.h"

#include <functional>
#include <vector>

namespace slicemorph {

/// What became of severed components.
struct Rejoined {
  int joints = 0;
  std::vector<LooseComponent> loose;  ///< those that still are
};

/// Joins components of the inside that were severed from the rest, while there are more than `allowed`. Where a thin limb
/// of one object lies beside that of the other by more than both are thick, the blend of distances breaks it. Two
/// components are joined by a cone between their deepest points next to the gap, as thick at its ends as they are there;
/// the gap must be narrower than both narrow bands. Not where one of them is thinner than two voxels throughout: such
/// fragments come off tips. `belongs`: whether each of these world points across the gap lies in some object's limb.
Rejoined rejoinComponents(FloatGrid& levelSet, int allowed,
                          const std::function<bool(const std::vector<Vec3d>&)>& belongs);

}  // namespace slicemorph

#pragma once

#include "engine/reconstruct/slice_scores.h"
#include "slicemorph/conventions.h"

namespace slicemorph {

/// Where a stack of planes lies in the world: pixel (x, y) of the plane at position s is
/// origin + x stepX + y stepY + s along.
struct StackPlacement {
  Vec3d origin{0, 0, 0}, stepX{1, 0, 0}, stepY{0, 1, 0};
  Vec3d along{0, 0, 1};  ///< per unit of position
};

/// A label's surface as zero level of a field on a lattice with one node a pixel and steps along the stack
/// near the pixel's size: half the label's lead over the best other one (a distance near the surface,
/// levelled off three pixels from it; negative inside), between the given planes as SliceScores has it. Where
/// the label is still there on the first or the last plane a cap closes it within half a gap; so does a
/// pixel's rim at the domain's border. The grid's transform is affine. Throws GeometryError where no plane
/// has the label.
FloatGrid::Ptr labelLevelSet(const SliceScores& scores, int label, const StackPlacement& placement);

}  // namespace slicemorph

#pragma once

#include "engine/reconstruct/slice_scores.h"
#include "slicemorph/conventions.h"

namespace slicemorph {

/// Position of a stack of planes in world space: pixel (x, y) of the plane at position s is at origin + x
/// stepX + y stepY + s along.
struct StackPlacement {
  Vec3d origin{0, 0, 0}, stepX{1, 0, 0}, stepY{0, 1, 0};
  Vec3d along{0, 0, 1};  ///< per unit of position
};

/// A label's surface as the zero level of a field on a lattice with one node per pixel and steps along the
/// stack close to the pixel size. The field is half the difference between the best other label's score and
/// the label's (negative inside; a distance near the surface, clamped three pixels from it), from SliceScores
/// between the given planes. If the label is present on the first or last plane, a cap closes it within half
/// a gap; at the border of the domain it is closed within a pixel. The grid's transform is affine. Throws
/// GeometryError if no plane has the label.
FloatGrid::Ptr labelLevelSet(const SliceScores& scores, int label, const StackPlacement& placement);

}  // namespace slicemorph

#pragma once

#include "engine/numerics/lattice.h"
#include "engine/reconstruct/plane_set.h"
#include "slicemorph/progress.h"

namespace slicemorph {

/// A function on a lattice in world space whose zero set is the surface; about a distance near
/// it, negative inside.
struct PlateSurface {
  Lattice lattice;
  std::vector<float> values;
};

/// The function of least bending energy (thin plate) that is zero on the planes' contours and close to
/// the planes' own signed distances near them, solved from coarse to fine (after [TO99], on a
/// lattice). `voxelSize`: spacing of the finest lattice, world units; its nodes are at whole multiples
/// of it. Throws Cancelled.
PlateSurface plateSurface(const PlaneSet& planes, double voxelSize, Progress* progress);

}  // namespace slicemorph

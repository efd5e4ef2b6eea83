#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/image.h"
#include "slicemorph/io/input_spec.h"

#include <vector>

namespace slicemorph {

/// A similarity of the world that an input is brought by to one size, one upright axis and one place with others:
/// p -> scale * rotation * p + move. Its inverse takes results back.
struct Placing {
  double scale = 1;
  Mat3d rotation = Mat3d::identity();
  Vec3d move{0, 0, 0};

  bool isIdentity() const { return scale == 1 && move == Vec3d(0.0) && rotation == Mat3d::identity(); }
  Vec3d operator()(const Vec3d& p) const { return scale * (rotation * p) + move; }
  /// This one after another.
  Placing after(const Placing& first) const {
    return {scale * first.scale, rotation * first.rotation, (*this)(first.move)};
  }
};

/// What stands in braces behind an input's name. `up`: the axis that points up in the job, to which the input's own is
/// turned.
Placing placingOf(const InputPlacing& asked, char up);

void place(std::vector<openvdb::Vec3s>& points, const Placing& placing);
void place(ImageLattice& lattice, const Placing& placing);
/// The grid itself where nothing changes; else one with another transform. Distances of level sets and velocities are
/// scaled, vectors that are no colours turned; other values stay.
openvdb::GridBase::Ptr placed(const openvdb::GridBase::Ptr& grid, const Placing& placing);

}  // namespace slicemorph

#pragma once

#include "engine/frame/align.h"

namespace slicemorph {

/// How an object moved from one frame of a sequence to the next: p -> to + scale * rotation * (p - from),
/// world.
struct Motion {
  Vec3d from{0, 0, 0}, to{0, 0, 0};
  Mat3d rotation = Mat3d::identity();
  double scale = 1;

  Vec3d operator()(const Vec3d& p) const { return to + scale * (rotation * (p - from)); }
};

/// Scaled as the volume, moved and turned as brings the two surfaces closest, the parts that deform counting
/// less (both ways point to plane [CM92]). It turns only as far as the surfaces tell: not at
/// all about an axis of symmetry, nor where one shape becomes another. `align` kNone: directions and size are
/// kept.
Motion trackMotion(const DistanceField& earlier, const DistanceField& now, Align align);

/// The charts, moved with their objects from the earlier fields to the present ones; those of equal fields
/// stay. Bends and the half length are kept. `names`: of the objects, for notes.
Frames trackFrames(const Frames& frames, const Fields& earlier, const Fields& now,
                   const std::vector<std::string>& names, Align align);

}  // namespace slicemorph

#pragma once

#include "engine/frame/align.h"

namespace slicemorph {

/// An object's motion from one frame of a sequence to the next: p -> to + scale * rotation *
/// (p - from), world.
struct Motion {
  Vec3d from{0, 0, 0}, to{0, 0, 0};
  Mat3d rotation = Mat3d::identity();
  double scale = 1;

  Vec3d operator()(const Vec3d& p) const { return to + scale * (rotation * (p - from)); }
};

/// The motion that scales by the cube root of the volumes' ratio and best aligns the two surfaces, by robust
/// point-to-plane ICP in both directions [CM92] in which parts that deform count less. It turns only as far
/// as the surfaces determine: not about an axis of symmetry, nor where one shape becomes another. With
/// Align::kNone directions and size are kept, with Align::kDirections directions.
Motion trackMotion(const DistanceField& earlier, const DistanceField& now, Align align);

/// The charts, moved along with their objects from the earlier fields to the present ones; charts of objects
/// with the same field stay. Bends and the half length are kept. `names`: of the objects, for notes.
Frames trackFrames(const Frames& frames, const Fields& earlier, const Fields& now,
                   const std::vector<std::string>& names, Align align);

}  // namespace slicemorph

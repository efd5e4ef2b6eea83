#pragma once

#include "tests/support/shapes.h"

#include <array>

namespace slicemorph::shapes {

/// A standing animal of capsules, z up: body along x, four legs, neck, head and tail. Legs 0 and 1 are the
/// front ones.
struct Quadruped {
  static constexpr double kLegLength = 0.62, kLegRadius = 0.065;
  using Swing = std::array<double, 4>;  ///< of each leg, degrees forwards

  static Vec3d hip(int leg) { return {leg < 2 ? 0.42 : -0.48, leg % 2 ? 0.13 : -0.13, 0.4}; }
  /// Unit direction of a leg from hip to foot.
  static Vec3d down(double swing) {
    const double a = swing * (3.14159265358979323846 / 180);
    return {std::sin(a), 0, -std::cos(a)};
  }
  /// Point on a leg's axis, `share` of the way down.
  static Vec3d onLeg(int leg, double swing, double share) {
    return hip(leg) + share * kLegLength * down(swing);
  }
};

/// `legs`: how many of them it has.
inline Distance quadruped(const Quadruped::Swing& swing, int legs = 4) {
  std::vector<Distance> parts{
      capsule({-0.55, 0, 0.45}, {0.5, 0, 0.45}, 0.17), capsule({0.5, 0, 0.5}, {0.78, 0, 0.85}, 0.09),
      capsule({0.78, 0, 0.85}, {0.98, 0, 0.8}, 0.1), capsule({-0.6, 0, 0.5}, {-0.85, 0, 0.3}, 0.05)};
  for (int leg = 0; leg < legs; ++leg)
    parts.push_back(
        capsule(Quadruped::hip(leg), Quadruped::onLeg(leg, swing[size_t(leg)], 1), Quadruped::kLegRadius));
  return joined(parts);
}

/// Around it, however far its legs swing up to 90 degrees.
inline openvdb::BBoxd quadrupedBox() { return {Vec3d(-1.2, -0.4, -0.4), Vec3d(1.2, 0.4, 1.1)}; }

}  // namespace slicemorph::shapes

#pragma once

#include "engine/blend/lattice_on_objects.h"

namespace slicemorph {

/// Arcs of circles in place of a map's parabolas where what lies between two objects swings far: a part that turns about
/// a hinge then keeps its length at all times. By 100 degrees a parabola comes 1 % nearer to the hinge, by 170 degrees 8 %.
class SwingPaths {
 public:
  /// None for other than two objects and where charts are bent. `on` must outlive it.
  explicit SwingPaths(const LatticeOnObjects& on);

  /// The in-between's offset from the parabola at each node, chart units; empty where nothing swings, and at the
  /// objects themselves.
  VectorField offsets(const Weights& weights) const;

 private:
  /// A node that swings: the arc is drawn about the middle of the way, lengths and angles in it are the world's.
  struct Arc {
    size_t node;
    openvdb::Vec3s before, after;   ///< the objects' positions from the one in the middle space, world units
    float angleBefore, angleAfter;  ///< of the arc from the middle to either
    float share;                    ///< how much of the arc is taken
  };
  const LatticeOnObjects& on_;
  Vec3d scale_{1, 1, 1};  ///< world units per chart unit, of the middle
  std::vector<Arc> arcs_;
};

}  // namespace slicemorph

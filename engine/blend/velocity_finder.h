#pragma once

#include "engine/blend/box_nodes.h"

#include <functional>
#include <optional>

namespace slicemorph {

/// Velocities of a lattice, world units per unit of time.
struct LatticeMotion {
  std::function<openvdb::Vec3s(size_t)> velocity;  ///< of a node of the lattice
  Chart from, to;   ///< of the in-betweens a little earlier and later, for points beyond the lattice
  double unit = 0;  ///< one over the time between these; 0: nothing moves
};

/// Velocities at nodes of one in-between's maps, of one transform and step. Only of those nodes of the lattice that are
/// around them is the velocity computed, once.
class VelocityFinder {
 public:
  /// All must outlive this.
  VelocityFinder(const LatticeMotion& motion, const Lattice& lattice, const LatticePose& pose,
                 const openvdb::math::Transform& transform, int step);

  /// Makes use of the places in a map of this in-between, transform and step, which must outlive this.
  void knows(const NodeMap& placed) { placed_.push_back(&placed); }

  /// Evaluates them at those nodes of a map that `wanted` marks, one flag a node; the others become unknown. The map has
  /// a single "object".
  NodeMap find(NodeMap map, const std::vector<char>& wanted);

 private:
  void place(NodeMap& map, const std::vector<char>& wanted);
  void computeAround(const NodeMap& map);

  const LatticeMotion& motion_;
  const Lattice& lattice_;
  const LatticePose& pose_;
  const openvdb::math::Transform& transform_;
  int step_;
  std::vector<const NodeMap*> placed_;
  std::optional<PlaceFinder> places_;  ///< made when a node is in no map
  VectorField velocity_;               ///< of the lattice's nodes, where they are computed
  std::vector<char> computed_;
};

}  // namespace slicemorph

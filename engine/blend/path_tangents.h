#pragma once

#include "engine/blend/lattice_on_objects.h"

#include <functional>

namespace slicemorph {

/// Makes paths between two objects of a sequence go on smoothly into those before and after: each node's path is a
/// cubic whose velocity at either object is the mean of both sides' [CR74].
class PathTangents {
 public:
  /// Where world points that are on one of the objects are by the neighbouring stretch of the sequence, in this
  /// stretch's time: of the first object one whole stretch earlier, of the second one later. Empty: there is none, and
  /// paths keep the velocity of the straight line at that end.
  using Neighbour = std::function<std::vector<Vec3d>(const std::vector<Vec3d>&)>;

  /// For two objects; none where charts are bent. `of`: the neighbours of either object. `on` must outlive it.
  PathTangents(const LatticeOnObjects& on, const std::array<Neighbour, 2>& of);

  /// Adds the in-between's offset from the straight path at each node, chart units; nothing at the objects themselves.
  void add(const Weights& weights, VectorField& offsets) const;

 private:
  const LatticeOnObjects& on_;
  /// Per object and node: by how much the velocity there differs from the straight path's, world units per stretch.
  std::array<VectorField, 2> more_;
};

}  // namespace slicemorph

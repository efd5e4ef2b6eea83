#pragma once

#include "engine/numerics/lattice_field.h"

namespace slicemorph {

/// Displacements of all objects from the middle space: object k has the middle point s at the chart point s +
/// of[k](s), an in-between of weights w at s + sum_k pathWeights(w)[k] of[k](s). Where the displacements sum
/// to zero the paths are straight lines; elsewhere they are parabolas through s, so that a swinging limb
/// keeps its length.
struct Displacements {
  Lattice lattice;              ///< in the middle chart space: half way between all objects
  std::vector<VectorField> of;  ///< per object: one vector per lattice node, chart units

  Vec3d at(size_t object, const Vec3d& s) const { return sampleField(lattice, of[object], s); }
};

/// The same map, sampled at the nodes of another lattice.
Displacements resampled(const Displacements& map, const Lattice& to);

/// The factor of each object's displacement in an in-between of these weights: 1 at the object itself (0 for
/// the others), 0 for all where the weights are equal. With n objects: w_k - (1 - sum w^2) / (n - 1).
Weights pathWeights(const Weights& weights);

/// Solves s + D(s) = a for the middle point s of an object's chart point a, by Newton's method from the
/// initial value of `s`. Returns whether it converged.
bool toMiddle(const Displacements& map, size_t object, const Vec3d& a, Vec3d& s);

/// The same for one displacement field, extrapolated beyond the lattice by sampleContinued.
bool toMiddleContinued(const Lattice& lattice, const VectorField& displacement, const Vec3d& a, Vec3d& s);

/// Finds a starting value for toMiddle where a map carries points far: from the lattice node whose image on
/// the object is nearest to the point.
class MiddleGuess {
 public:
  MiddleGuess(const Lattice& lattice, const VectorField& displacement);
  /// `a`: chart point of the object. Returns `a` itself where no node's image is near.
  Vec3d near(const Vec3d& a) const;

 private:
  Lattice lattice_;                ///< of the map; its cells also serve as bins
  std::vector<Vec3d> position_;    ///< per node: its image on the object
  std::vector<int> first_, next_;  ///< linked lists of the nodes in each bin; -1: end of the list
};

}  // namespace slicemorph

#pragma once

#include "engine/numerics/lattice_field.h"

namespace slicemorph {

/// Every object's displacement from the middle space: object k's chart point of a middle point s is s +
/// of[k](s). An in-between has it at s + sum_k pathWeights(w)[k] of[k](s). Where the displacements sum to
/// zero the paths are straight lines; elsewhere they are parabolas through s, so that a limb that swings
/// keeps its length.
struct Displacements {
  Lattice lattice;  ///< in the middle chart space: half way between all objects
  std::vector<VectorField> of;

  Vec3d at(size_t object, const Vec3d& s) const { return sampleField(lattice, of[object], s); }
};

/// The same map on another lattice.
Displacements resampled(const Displacements& map, const Lattice& to);

/// How much of each object's displacement an in-between of these weights takes: all of one's own, none half
/// way between all objects.
Weights pathWeights(const Weights& weights);

/// Middle point of an object's chart point, by Newton's method on s + D(s) = a from a guess at s. Returns
/// whether it is one.
bool toMiddle(const Displacements& map, size_t object, const Vec3d& a, Vec3d& s);

/// The same for one field of displacements that goes on beyond the lattice as sampleContinued.
bool toMiddleContinued(const Lattice& lattice, const VectorField& displacement, const Vec3d& a, Vec3d& s);

/// Where to start toMiddle from if a map carries points far: the middle point of the node that lies nearest
/// on the object.
class MiddleGuess {
 public:
  MiddleGuess(const Lattice& lattice, const VectorField& displacement);
  Vec3d near(const Vec3d& a) const;

 private:
  Lattice lattice_;                ///< of the map; its cells are the bins, too
  std::vector<Vec3d> position_;    ///< per node
  std::vector<int> first_, next_;  ///< nodes of a bin, linked; -1: no more
};

}  // namespace slicemorph

#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Regular lattice in the middle chart space: the space half way between all objects.
struct Lattice {
  Vec3d origin{0, 0, 0};
  double spacing = 1;
  openvdb::Coord size{1, 1, 1};

  size_t count() const { return size_t(size[0]) * size[1] * size[2]; }
  size_t index(int x, int y, int z) const { return (size_t(z) * size[1] + y) * size[0] + x; }
  Vec3d position(int x, int y, int z) const { return origin + spacing * Vec3d(x, y, z); }
  /// Covers `box` with nodes `spacing` apart, centred on it.
  static Lattice over(const openvdb::BBoxd& box, double spacing);
};

/// One vector per node.
using VectorField = std::vector<openvdb::Vec3s>;

/// Trilinear value; zero beyond the lattice.
Vec3d sampleField(const Lattice& lattice, const VectorField& field, const Vec3d& z);

/// Trilinear value; beyond the lattice that of its nearest point.
Vec3d sampleContinued(const Lattice& lattice, const VectorField& field, const Vec3d& z);

/// The field on another lattice, by Catmull-Rom splines: no creases at the coarse nodes. Zero beyond the
/// lattice.
VectorField resampleField(const Lattice& from, const VectorField& field, const Lattice& to);

/// Every object's displacement from the middle space: object k's chart point of a middle point s is s +
/// of[k](s). An in-between has it at s + sum_k pathWeights(w)[k] of[k](s). Where the displacements sum to
/// zero the ways are straight lines; elsewhere they are parabolas by way of s, so that a limb that swings
/// keeps its length.
struct Displacements {
  Lattice lattice;
  std::vector<VectorField> of;

  Vec3d at(size_t object, const Vec3d& s) const { return sampleField(lattice, of[object], s); }
};

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
  std::vector<Vec3d> place_;       ///< per node
  std::vector<int> first_, next_;  ///< nodes of a bin, linked; -1: no more
};

/// The same map on another lattice.
Displacements resampled(const Displacements& map, const Lattice& to);

}  // namespace slicemorph

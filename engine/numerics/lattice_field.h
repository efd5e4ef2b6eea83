#pragma once

#include "engine/numerics/lattice.h"

namespace slicemorph {

/// One vector per node.
using VectorField = std::vector<openvdb::Vec3s>;

/// Trilinear value; zero beyond the lattice.
Vec3d sampleField(const Lattice& lattice, const VectorField& field, const Vec3d& p);

/// Trilinear value; beyond the lattice that of its nearest point.
Vec3d sampleContinued(const Lattice& lattice, const VectorField& field, const Vec3d& p);

/// The field on another lattice, by Catmull-Rom splines: no creases at the coarse nodes. Zero beyond the
/// lattice.
VectorField resampleField(const Lattice& from, const VectorField& field, const Lattice& to);

}  // namespace slicemorph

#pragma once

#include "engine/numerics/lattice.h"

namespace slicemorph {

/// One vector per node.
using VectorField = std::vector<openvdb::Vec3s>;

/// Trilinear value; zero outside the lattice.
Vec3d sampleField(const Lattice& lattice, const VectorField& field, const Vec3d& p);

/// Trilinear value; outside the lattice, that of the nearest point of the lattice.
Vec3d sampleContinued(const Lattice& lattice, const VectorField& field, const Vec3d& p);

/// The field resampled on another lattice by Catmull-Rom splines, which have no creases at the coarse nodes.
/// Values beyond the first lattice count as zero.
VectorField resampleField(const Lattice& from, const VectorField& field, const Lattice& to);

}  // namespace slicemorph

#pragma once

#include "engine/numerics/lattice_field.h"

#include <functional>
#include <random>

namespace slicemorph {

/// A field's values of `f` at a lattice's nodes.
inline VectorField sampled(const Lattice& lattice, const std::function<Vec3d(const Vec3d&)>& f) {
  VectorField field(lattice.count());
  for (int z = 0; z < lattice.size[2]; ++z)
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x)
        field[lattice.index(x, y, z)] = openvdb::Vec3s(f(lattice.position(x, y, z)));
  return field;
}

/// Points spread over the box of a lattice, and up to `beyond` outside it. The same points in every run.
inline std::vector<Vec3d> pointsIn(const Lattice& lattice, int count, double beyond = 0) {
  std::mt19937 random(3);
  const Vec3d extent = lattice.spacing * (lattice.size.asVec3d() - Vec3d(1));
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i) {
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = lattice.origin[a] + std::uniform_real_distribution<>(-beyond, extent[a] + beyond)(random);
    points.push_back(p);
  }
  return points;
}

}  // namespace slicemorph

#include "engine/match/displacements.h"

#include <algorithm>

namespace slicemorph {

namespace {

/// toMiddle for any displacement D(s). `spacing`: of its lattice; steps and tolerances are fractions of it.
template <typename Displacement>
bool solveMiddle(const Displacement& displacement, double spacing, const Vec3d& a, Vec3d& s) {
  const double h = 0.5 * spacing;
  for (int i = 0; i < 12; ++i) {
    const Vec3d r = a - s - displacement(s);
    if (r.length() < 1e-3 * spacing) return true;
    Mat3d jacobian;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d e(0.0);
      e[axis] = h;
      Vec3d column = (displacement(s + e) - displacement(s - e)) / (2 * h);
      column[axis] += 1;
      for (int row = 0; row < 3; ++row) jacobian(row, axis) = column[row];
    }
    Vec3d step = jacobian.det() > 0.02 ? jacobian.inverse() * r : 0.5 * r;
    const double longest = 2 * spacing;
    if (step.length() > longest) step *= longest / step.length();
    s += step;
  }
  return (a - s - displacement(s)).length() < 0.2 * spacing;
}

}  // namespace

Displacements resampled(const Displacements& map, const Lattice& to) {
  Displacements result{to, {}};
  for (const VectorField& field : map.of) result.of.push_back(resampleField(map.lattice, field, to));
  return result;
}

Weights pathWeights(const Weights& weights) {
  const double n = double(weights.size());
  if (n < 2) return Weights(weights.size(), 1);
  double squares = 0;
  for (double w : weights) squares += w * w;
  const double middle = (1 - squares) / (1 - 1 / n);  // 0 at every object, 1 half way between all
  Weights result = weights;
  for (double& w : result) w -= middle / n;
  return result;
}

bool toMiddle(const Displacements& map, size_t object, const Vec3d& a, Vec3d& s) {
  return solveMiddle([&](const Vec3d& p) { return map.at(object, p); }, map.lattice.spacing, a, s);
}

bool toMiddleContinued(const Lattice& lattice, const VectorField& displacement, const Vec3d& a, Vec3d& s) {
  return solveMiddle([&](const Vec3d& p) { return sampleContinued(lattice, displacement, p); },
                     lattice.spacing, a, s);
}

MiddleGuess::MiddleGuess(const Lattice& lattice, const VectorField& displacement)
    : lattice_(lattice),
      position_(lattice_.count()),
      first_(lattice_.count(), -1),
      next_(lattice_.count(), -1) {
  for (int z = 0; z < lattice_.size[2]; ++z)
    for (int y = 0; y < lattice_.size[1]; ++y)
      for (int x = 0; x < lattice_.size[0]; ++x) {
        const size_t i = lattice_.index(x, y, z);
        position_[i] = lattice_.position(x, y, z) + Vec3d(displacement[i]);
        const openvdb::Coord c = openvdb::Coord::floor((position_[i] - lattice_.origin) / lattice_.spacing);
        if (c.x() < 0 || c.y() < 0 || c.z() < 0 || c.x() >= lattice_.size[0] || c.y() >= lattice_.size[1] ||
            c.z() >= lattice_.size[2])
          continue;
        int& first = first_[lattice_.index(c.x(), c.y(), c.z())];
        next_[i] = first, first = int(i);
      }
}

Vec3d MiddleGuess::near(const Vec3d& a) const {
  const openvdb::Coord c = openvdb::Coord::floor((a - lattice_.origin) / lattice_.spacing);
  int best = -1;
  double least = 1e30;
  for (int z = std::max(c.z() - 1, 0); z <= std::min(c.z() + 1, lattice_.size[2] - 1); ++z)
    for (int y = std::max(c.y() - 1, 0); y <= std::min(c.y() + 1, lattice_.size[1] - 1); ++y)
      for (int x = std::max(c.x() - 1, 0); x <= std::min(c.x() + 1, lattice_.size[0] - 1); ++x)
        for (int i = first_[lattice_.index(x, y, z)]; i >= 0; i = next_[size_t(i)])
          if (const double d = (position_[size_t(i)] - a).lengthSqr(); d < least) least = d, best = i;
  if (best < 0) return a;
  const int nx = lattice_.size[0], nxy = nx * lattice_.size[1];
  return lattice_.position(best % nx, best % nxy / nx, best / nxy) + a - position_[size_t(best)];
}

}  // namespace slicemorph

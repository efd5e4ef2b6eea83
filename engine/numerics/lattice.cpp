#include "engine/numerics/lattice.h"

#include "engine/numerics/catmull_rom.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

struct Taps {
  int base = 0;
  std::array<double, 4> w;
};

/// Catmull-Rom weights of the four nodes base .. base + 3.
Taps catmullRom(double x) {
  const double f = std::floor(x);
  return {int(f) - 1, catmullRomWeights(x - f)};
}

/// Trilinear value at a point in units of the spacing from the lattice's origin, not beyond the lattice.
Vec3d interpolated(const Lattice& lattice, const VectorField& field, const Vec3d& q) {
  int base[3];
  float w[3];
  for (int a = 0; a < 3; ++a) {
    base[a] = std::min(int(q[a]), lattice.size[a] - 2);
    w[a] = float(q[a] - base[a]);
  }
  const openvdb::Vec3s* v = &field[lattice.index(base[0], base[1], base[2])];
  const size_t dy = lattice.size[0], dz = size_t(lattice.size[0]) * lattice.size[1];
  const auto row = [&](size_t o) { return v[o] + (v[o + 1] - v[o]) * w[0]; };
  const openvdb::Vec3s n0 = row(0), n1 = row(dy), f0 = row(dz), f1 = row(dz + dy);
  const openvdb::Vec3s near = n0 + (n1 - n0) * w[1], far = f0 + (f1 - f0) * w[1];
  return Vec3d(near + (far - near) * w[2]);
}

/// toMiddle for any displacement D(s), known on a lattice of this spacing.
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

Lattice Lattice::over(const openvdb::BBoxd& box, double spacing) {
  Lattice lattice;
  lattice.spacing = spacing;
  const Vec3d extent = box.extents();
  for (int a = 0; a < 3; ++a) lattice.size[a] = std::max(2, int(std::ceil(extent[a] / spacing - 1e-9)) + 1);
  const Vec3d covered = spacing * Vec3d(lattice.size[0] - 1, lattice.size[1] - 1, lattice.size[2] - 1);
  lattice.origin = box.getCenter() - 0.5 * covered;
  return lattice;
}

Vec3d sampleField(const Lattice& lattice, const VectorField& field, const Vec3d& z) {
  const Vec3d q = (z - lattice.origin) / lattice.spacing;
  for (int a = 0; a < 3; ++a)
    if (!(q[a] >= 0) || q[a] > lattice.size[a] - 1) return Vec3d(0.0);
  return interpolated(lattice, field, q);
}

Vec3d sampleContinued(const Lattice& lattice, const VectorField& field, const Vec3d& z) {
  Vec3d q = (z - lattice.origin) / lattice.spacing;
  for (int a = 0; a < 3; ++a) q[a] = std::min(std::max(q[a], 0.0), lattice.size[a] - 1.0);
  return interpolated(lattice, field, q);
}

VectorField resampleField(const Lattice& from, const VectorField& field, const Lattice& to) {
  // One axis after the other; what is not yet resampled keeps its old size.
  std::vector<Vec3d> values(field.begin(), field.end());
  openvdb::Coord size = from.size;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Taps> taps;
    for (int i = 0; i < to.size[axis]; ++i)
      taps.push_back(catmullRom((to.position(i, i, i)[axis] - from.origin[axis]) / from.spacing));
    const size_t stride = axis == 0 ? 1 : axis == 1 ? size_t(size[0]) : size_t(size[0]) * size[1];
    const size_t lines = values.size() / (stride * size[axis]);
    std::vector<Vec3d> along(stride * to.size[axis] * lines);
    tbb::parallel_for(size_t(0), lines * to.size[axis], [&](size_t row) {
      const Taps& t = taps[row % to.size[axis]];
      const size_t first = row / to.size[axis] * stride * size[axis];
      for (size_t n = 0; n < stride; ++n) {
        Vec3d sum(0.0);
        for (int i = 0; i < 4; ++i)
          if (const int at = t.base + i; at >= 0 && at < size[axis])
            sum += t.w[i] * values[first + at * stride + n];
        along[row * stride + n] = sum;
      }
    });
    values.swap(along);
    size[axis] = to.size[axis];
  }
  return {values.begin(), values.end()};
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
    : lattice_(lattice), place_(lattice_.count()), first_(lattice_.count(), -1), next_(lattice_.count(), -1) {
  for (int z = 0; z < lattice_.size[2]; ++z)
    for (int y = 0; y < lattice_.size[1]; ++y)
      for (int x = 0; x < lattice_.size[0]; ++x) {
        const size_t i = lattice_.index(x, y, z);
        place_[i] = lattice_.position(x, y, z) + Vec3d(displacement[i]);
        const openvdb::Coord c = openvdb::Coord::floor((place_[i] - lattice_.origin) / lattice_.spacing);
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
          if (const double d = (place_[size_t(i)] - a).lengthSqr(); d < least) least = d, best = i;
  if (best < 0) return a;
  const int nx = lattice_.size[0], nxy = nx * lattice_.size[1];
  return lattice_.position(best % nx, best % nxy / nx, best / nxy) + a - place_[size_t(best)];
}

Displacements resampled(const Displacements& map, const Lattice& to) {
  Displacements result{to, {}};
  for (const VectorField& field : map.of) result.of.push_back(resampleField(map.lattice, field, to));
  return result;
}

}  // namespace slicemorph

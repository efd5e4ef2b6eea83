#include "engine/numerics/lattice_field.h"

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

/// Trilinear value at `q`, in node units, which must not be outside the lattice.
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

/// Values on a lattice of this size, at the nodes of `to` along one axis; along the others they stay where they are.
template <typename To, typename From>
std::vector<To> resampledAlong(int axis, const std::vector<From>& values, const openvdb::Coord& size,
                               const Lattice& from, const Lattice& to) {
  std::vector<Taps> taps;
  taps.reserve(size_t(to.size[axis]));
  for (int i = 0; i < to.size[axis]; ++i)
    taps.push_back(catmullRom((to.position(i, i, i)[axis] - from.origin[axis]) / from.spacing));
  const size_t stride = axis == 0 ? 1 : axis == 1 ? size_t(size[0]) : size_t(size[0]) * size[1];
  const size_t lines = values.size() / (stride * size[axis]);
  std::vector<To> along(stride * to.size[axis] * lines);
  tbb::parallel_for(size_t(0), lines * to.size[axis], [&](size_t row) {
    const Taps& t = taps[row % to.size[axis]];
    const size_t first = row / to.size[axis] * stride * size[axis];
    for (size_t n = 0; n < stride; ++n) {
      Vec3d sum(0.0);
      for (int i = 0; i < 4; ++i)
        if (const int at = t.base + i; at >= 0 && at < size[axis])
          sum += t.w[i] * Vec3d(values[first + at * stride + n]);
      along[row * stride + n] = To(sum);
    }
  });
  return along;
}

}  // namespace

Vec3d sampleField(const Lattice& lattice, const VectorField& field, const Vec3d& p) {
  const Vec3d q = (p - lattice.origin) / lattice.spacing;
  for (int a = 0; a < 3; ++a)
    if (!(q[a] >= 0) || q[a] > lattice.size[a] - 1) return Vec3d(0.0);
  return interpolated(lattice, field, q);
}

Vec3d sampleContinued(const Lattice& lattice, const VectorField& field, const Vec3d& p) {
  Vec3d q = (p - lattice.origin) / lattice.spacing;
  for (int a = 0; a < 3; ++a) q[a] = std::min(std::max(q[a], 0.0), lattice.size[a] - 1.0);
  return interpolated(lattice, field, q);
}

VectorField resampleField(const Lattice& from, const VectorField& field, const Lattice& to) {
  // One axis after the other; axes not yet resampled keep their size.
  openvdb::Coord size = from.size;
  const std::vector<Vec3d> alongX = resampledAlong<Vec3d>(0, field, size, from, to);
  size[0] = to.size[0];
  const std::vector<Vec3d> alongXY = resampledAlong<Vec3d>(1, alongX, size, from, to);
  size[1] = to.size[1];
  return resampledAlong<openvdb::Vec3s>(2, alongXY, size, from, to);
}

}  // namespace slicemorph

#include "engine/match/lattice.h"

#include "engine/match/catmull_rom.h"

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
  int base[3];
  float w[3];
  for (int a = 0; a < 3; ++a) {
    if (!(q[a] >= 0) || q[a] > lattice.size[a] - 1) return Vec3d(0.0);
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

VectorField resampleField(const Lattice& from, const VectorField& field, const Lattice& to) {
  VectorField result(to.count(), openvdb::Vec3s(0.f));
  tbb::parallel_for(0, int(to.size[2]), [&](int z) {
    for (int y = 0; y < to.size[1]; ++y)
      for (int x = 0; x < to.size[0]; ++x) {
        const Vec3d q = (to.position(x, y, z) - from.origin) / from.spacing;
        const Taps tx = catmullRom(q[0]), ty = catmullRom(q[1]), tz = catmullRom(q[2]);
        Vec3d sum(0.0);
        for (int k = 0; k < 4; ++k)
          for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) {
              const int a = tx.base + i, b = ty.base + j, c = tz.base + k;
              if (a < 0 || b < 0 || c < 0 || a >= from.size[0] || b >= from.size[1] || c >= from.size[2]) continue;
              sum += tx.w[i] * ty.w[j] * tz.w[k] * Vec3d(field[from.index(a, b, c)]);
            }
        result[to.index(x, y, z)] = openvdb::Vec3s(sum);
      }
  });
  return result;
}

Displacements resampled(const Displacements& map, const Lattice& to) {
  Displacements result{to, {}};
  for (const VectorField& field : map.of) result.of.push_back(resampleField(map.lattice, field, to));
  return result;
}

}  // namespace slicemorph

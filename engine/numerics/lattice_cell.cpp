#include "engine/numerics/lattice_cell.h"

#include <algorithm>

namespace slicemorph {

CellPoint cellPoint(const Lattice& lattice, const Vec3d& p) {
  const Vec3d q = (p - lattice.origin) / lattice.spacing;
  int base[3];
  double share[3];
  for (int a = 0; a < 3; ++a) {
    const double clamped = std::clamp(q[a], 0.0, double(lattice.size[a] - 1));
    base[a] = std::min(int(clamped), lattice.size[a] - 2);
    share[a] = clamped - base[a];
  }
  return {std::uint32_t(lattice.index(base[0], base[1], base[2])), float(share[0]), float(share[1]),
          float(share[2])};
}

std::array<std::uint32_t, 8> cornerOffsets(const Lattice& lattice) {
  std::array<std::uint32_t, 8> offsets;
  for (int c = 0; c < 8; ++c) offsets[c] = std::uint32_t(lattice.index(c & 1, c >> 1 & 1, c >> 2));
  return offsets;
}

double valueAt(const Lattice& lattice, const std::vector<float>& values, const CellPoint& point) {
  const std::array<std::uint32_t, 8> corners = cornerOffsets(lattice);
  double sum = 0;
  for (int c = 0; c < 8; ++c) sum += double(point.weight(c)) * values[point.cell + corners[c]];
  return sum;
}

Vec3d gradientAt(const Lattice& lattice, const std::vector<float>& values, const CellPoint& point) {
  const std::array<std::uint32_t, 8> corners = cornerOffsets(lattice);
  Vec3d sum(0.0);
  for (int c = 0; c < 8; ++c) {
    const double f = values[point.cell + corners[c]];
    const double u = c & 1 ? point.u : 1 - point.u, v = c & 2 ? point.v : 1 - point.v,
                 w = c & 4 ? point.w : 1 - point.w;
    sum += f * Vec3d((c & 1 ? 1 : -1) * v * w, (c & 2 ? 1 : -1) * u * w, (c & 4 ? 1 : -1) * u * v);
  }
  return sum / lattice.spacing;
}

}  // namespace slicemorph

#include "engine/volume/same_image.h"

#include <algorithm>

namespace slicemorph {

bool sameLattice(const ImageLattice& a, const ImageLattice& b, double tolerance) {
  if (a.size != b.size) return false;
  const double voxel = std::min({a.spacing()[0], a.spacing()[1], a.spacing()[2]});
  for (int c = 0; c < 8; ++c) {
    const Vec3d v((c & 1) * (a.size[0] - 1), (c >> 1 & 1) * (a.size[1] - 1), (c >> 2) * (a.size[2] - 1));
    if ((a.toWorld(v) - b.toWorld(v)).length() > tolerance * voxel) return false;
  }
  return true;
}

bool isSame(const Image& a, const Image& b) {
  if (&a == &b) return true;
  if (!sameLattice(a.lattice, b.lattice)) return false;
  return std::visit(
      [](const auto& v, const auto& w) {
        return std::equal(v.begin(), v.end(), w.begin(), w.end(), [](auto x, auto y) {
          const double p = double(x), q = double(y);
          return p == q || (p != p && q != q);
        });
      },
      a.values, b.values);
}

}  // namespace slicemorph

#include "engine/numerics/lattice.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

Lattice Lattice::over(const openvdb::BBoxd& box, double spacing) {
  Lattice lattice;
  lattice.spacing = spacing;
  const Vec3d extent = box.extents();
  for (int a = 0; a < 3; ++a) lattice.size[a] = std::max(2, int(std::ceil(extent[a] / spacing - 1e-9)) + 1);
  const Vec3d covered = spacing * Vec3d(lattice.size[0] - 1, lattice.size[1] - 1, lattice.size[2] - 1);
  lattice.origin = box.getCenter() - 0.5 * covered;
  return lattice;
}

}  // namespace slicemorph

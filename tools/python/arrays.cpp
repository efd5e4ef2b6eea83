#include "tools/python/arrays.h"

#include <cmath>

namespace slicemorph {

py::array_t<double> affineOf(const ImageLattice& lattice) {
  py::array_t<double> affine({4, 4});
  auto to = affine.mutable_unchecked<2>();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      to(row, column) = row == 3      ? column == 3
                        : column == 3 ? lattice.origin[row]
                                      : lattice.step[column][row];
  return affine;
}

ImageLattice latticeOf(const Rows<double>& affine) {
  if (affine.ndim() != 2 || affine.shape(0) != 4 || affine.shape(1) != 4)
    throw InputError("affine: expected 4 x 4 numbers that take voxels to the world");
  const auto from = affine.unchecked<2>();
  ImageLattice lattice;
  bool finite = true;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      finite = finite && std::isfinite(from(row, column));
      (column == 3 ? lattice.origin : lattice.step[column])[row] = from(row, column);
    }
  const double volume = lattice.step[0].dot(lattice.step[1].cross(lattice.step[2]));
  if (!finite || from(3, 0) != 0 || from(3, 1) != 0 || from(3, 2) != 0 || from(3, 3) != 1 ||
      !(std::abs(volume) > 0))
    throw InputError(
        "affine: expected finite numbers, a last row of 0 0 0 1, and columns that do not lie in one plane");
  return lattice;
}

}  // namespace slicemorph

#pragma once

#include "slicemorph/errors.h"
#include "slicemorph/image.h"

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

/// Arrays of numpy and the engine's own.
namespace slicemorph {

namespace py = pybind11;

/// An array of numbers of one type, row by row; others are converted.
template <typename T>
using Rows = py::array_t<T, py::array::c_style | py::array::forcecast>;

/// An array of what `owner` holds, without a copy; it keeps the owner alive, and can be written to only where the owner is
/// not const. `strides`: in bytes.
template <typename T, typename Owner>
py::array arrayOf(const std::shared_ptr<Owner>& owner, const T* data, std::vector<py::ssize_t> shape,
                  std::vector<py::ssize_t> strides) {
  const py::capsule base(new std::shared_ptr<const void>(owner),
                         [](void* held) { delete static_cast<std::shared_ptr<const void>*>(held); });
  py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, base);
  if (std::is_const_v<Owner>) array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// An N x 3 array of a list of vectors, which it takes over.
template <typename Vector>
py::array rowsOf(std::vector<Vector> vectors) {
  using Number = typename Vector::value_type;
  const auto owner = std::make_shared<std::vector<Vector>>(std::move(vectors));
  return arrayOf(owner, reinterpret_cast<const Number*>(owner->data()), {py::ssize_t(owner->size()), 3},
                 {py::ssize_t(sizeof(Vector)), py::ssize_t(sizeof(Number))});
}

/// A list of vectors of an N x 3 array. Throws InputError for another shape; `what`: names the array.
template <typename Vector>
std::vector<Vector> vectorsOf(const Rows<typename Vector::value_type>& rows, const std::string& what) {
  if (rows.ndim() != 2 || rows.shape(1) != 3)
    throw InputError(what + ": expected an array of N x 3 numbers, not of " + std::to_string(rows.ndim()) +
                     " dimensions" +
                     (rows.ndim() == 2 ? " with " + std::to_string(rows.shape(1)) + " columns" : ""));
  std::vector<Vector> vectors(size_t(rows.shape(0)));
  for (size_t n = 0; n < vectors.size(); ++n)
    for (int d = 0; d < 3; ++d) vectors[n][d] = rows.data()[3 * n + size_t(d)];
  return vectors;
}

/// The 4 x 4 matrix that takes voxels to the world.
py::array_t<double> affineOf(const ImageLattice& lattice);
/// The lattice of such a matrix, without its size. Throws InputError for another shape, and for a matrix that is not finite,
/// not affine or flat.
ImageLattice latticeOf(const Rows<double>& affine);

}  // namespace slicemorph

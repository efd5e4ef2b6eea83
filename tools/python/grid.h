#pragma once

#include "slicemorph/mesh.h"
#include "tools/python/arrays.h"

#include <pybind11/pybind11.h>

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// A grid as Python has it. Its values are shared with whatever made it and are never changed.
struct PyGrid {
  openvdb::GridBase::ConstPtr grid;
};

/// The grid's origin and steps as a lattice of no size; throws InputError for a transform that is not linear.
ImageLattice latticeOf(const openvdb::GridBase& grid);

/// Triangles of a level set's surface, and its colours where there are some, as a pair of arrays and an array or None.
py::tuple meshOf(const FloatGrid& levelSet, const openvdb::Vec3SGrid* colors, double iso = 0);
py::tuple arraysOf(Mesh mesh);

void addGrid(py::module_& module);

}  // namespace slicemorph

#include "tools/python/grid.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/io/vdb_reader.h"

#include <openvdb/io/Stream.h>
#include <openvdb/tools/Dense.h>

#include <sstream>

namespace slicemorph {
namespace {

using openvdb::GridBase;

/// Grids whose values become arrays: of numbers, of flags (as bool), of vectors (with a fourth axis).
using ArrayGrids = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                     openvdb::BoolGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid>;

template <typename Value, bool = openvdb::VecTraits<Value>::IsVec>
struct ArrayValue {
  using Number = Value;
  static constexpr int kSize = 1;
};
template <typename Value>
struct ArrayValue<Value, true> {
  using Number = typename Value::value_type;
  static constexpr int kSize = 3;
};

[[noreturn]] void refuseType(const GridBase& grid) {
  throw InputError("grid '" + grid.getName() + "'",
                   "values of the type " + grid.valueType() + " make no array");
}

using Box = std::pair<std::array<int, 3>, std::array<int, 3>>;

openvdb::CoordBBox boxOf(const GridBase& grid, const std::optional<Box>& asked) {
  if (!asked) return grid.evalActiveVoxelBoundingBox();
  const auto& [from, to] = *asked;
  const openvdb::CoordBBox box({from[0], from[1], from[2]}, {to[0], to[1], to[2]});
  if (box.empty())
    throw InputError("box: expected ((i, j, k), (i, j, k)), the first voxel and the last one, both inside");
  return box;
}

template <typename Grid>
py::array denseOf(const Grid& grid, const openvdb::CoordBBox& box) {
  using Value = typename Grid::ValueType;
  using Number = typename ArrayValue<Value>::Number;
  std::vector<py::ssize_t> shape;
  for (int d = 0; d < 3; ++d) shape.push_back(box.empty() ? 0 : box.dim()[d]);
  if (ArrayValue<Value>::kSize > 1) shape.push_back(ArrayValue<Value>::kSize);
  py::array_t<Number> array(shape);
  if (box.empty()) return std::move(array);
  auto* const values = reinterpret_cast<Value*>(array.mutable_data());
  const py::gil_scoped_release released;
  openvdb::tools::Dense<Value, openvdb::tools::LayoutZYX> dense(box, values);
  openvdb::tools::copyToDense(grid, dense);
  return std::move(array);
}

py::array toNumpy(const PyGrid& self, const std::optional<Box>& asked) {
  const openvdb::CoordBBox box = boxOf(*self.grid, asked);
  py::array array;
  if (!self.grid->apply<ArrayGrids>([&](const auto& grid) { array = denseOf(grid, box); }))
    refuseType(*self.grid);
  return array;
}

template <typename Grid>
GridBase::Ptr sparseOf(const Rows<typename ArrayValue<typename Grid::ValueType>::Number>& array,
                       double background, double tolerance) {
  using Value = typename Grid::ValueType;
  auto* const values =
      reinterpret_cast<Value*>(const_cast<typename ArrayValue<Value>::Number*>(array.data()));
  const openvdb::Coord last(int(array.shape(0)) - 1, int(array.shape(1)) - 1, int(array.shape(2)) - 1);
  const py::gil_scoped_release released;
  const typename Grid::Ptr grid = Grid::create(Value(background));
  const openvdb::tools::Dense<Value, openvdb::tools::LayoutZYX> dense({openvdb::Coord(0), last}, values);
  openvdb::tools::copyFromDense(dense, *grid, Value(tolerance));
  return grid;
}

openvdb::GridClass classNamed(const std::string& name) {
  if (name == "level set") return openvdb::GRID_LEVEL_SET;
  if (name == "fog volume") return openvdb::GRID_FOG_VOLUME;
  if (name == "unknown") return openvdb::GRID_UNKNOWN;
  throw InputError("grid_class", "'" + name + "' is none; there are 'level set', 'fog volume', 'unknown'");
}

PyGrid fromNumpy(const py::array& array, const Rows<double>& affine, const std::string& name,
                 const std::string& gridClass, double background, double tolerance) {
  const openvdb::GridClass kind = classNamed(gridClass);
  const bool vectors = array.ndim() == 4 && array.shape(3) == 3;
  if ((array.ndim() != 3 && !vectors) || array.size() == 0)
    throw InputError("array",
                     "expected one of three axes i, j, k, or four of which the last has 3 components");
  const bool doubles = array.dtype().is(py::dtype::of<double>());
  GridBase::Ptr grid;
  if (vectors)
    grid = sparseOf<openvdb::Vec3SGrid>(array, background, tolerance);
  else if (array.dtype().kind() == 'b')
    grid = sparseOf<openvdb::BoolGrid>(array, background, tolerance);
  else if (array.dtype().kind() == 'f')
    grid = doubles ? sparseOf<openvdb::DoubleGrid>(array, background, tolerance)
                   : sparseOf<FloatGrid>(array, background, tolerance);
  else
    grid = sparseOf<openvdb::Int32Grid>(array, background, tolerance);
  grid->setTransform(transformOf(latticeOf(affine)));
  grid->setName(name);
  grid->setGridClass(kind);
  return {grid};
}

py::bytes toBytes(const PyGrid& self) {
  std::ostringstream stream(std::ios::binary);
  {
    const py::gil_scoped_release released;
    openvdb::io::Stream(stream).write(openvdb::GridCPtrVec{self.grid});
  }
  return stream.str();
}

PyGrid fromBytes(const py::bytes& bytes) {
  std::string text(bytes);
  const py::gil_scoped_release released;
  initialiseVdb();
  std::istringstream stream(std::move(text), std::ios::binary);
  try {
    const openvdb::GridPtrVecPtr grids = openvdb::io::Stream(stream).getGrids();
    if (grids && !grids->empty()) return {grids->front()};
  } catch (const openvdb::Exception& error) {
    throw InputError("bytes", std::string("are no grid as pyopenvdb pickles it: ") + error.what());
  }
  throw InputError("bytes", "hold no grid");
}

py::tuple boxTuple(const PyGrid& self) {
  const openvdb::CoordBBox box = self.grid->evalActiveVoxelBoundingBox();
  if (box.empty()) return py::make_tuple(py::none(), py::none());
  const auto tuple = [](const openvdb::Coord& c) { return py::make_tuple(c[0], c[1], c[2]); };
  return py::make_tuple(tuple(box.min()), tuple(box.max()));
}

py::tuple toMesh(const PyGrid& self, double iso) {
  const auto floats = openvdb::GridBase::grid<FloatGrid>(self.grid);
  if (!floats)
    throw InputError("grid '" + self.grid->getName() + "'",
                     "holds " + self.grid->valueType() + " values; only floats have a surface");
  return meshOf(*floats, nullptr, iso);
}

}  // namespace

ImageLattice latticeOf(const GridBase& grid) {
  const openvdb::math::Transform& transform = grid.transform();
  if (!transform.isLinear())
    throw InputError("grid '" + grid.getName() + "'", "has a transform that is no matrix");
  ImageLattice lattice;
  lattice.origin = transform.indexToWorld(Vec3d(0.0));
  for (int d = 0; d < 3; ++d) {
    Vec3d one(0.0);
    one[d] = 1;
    lattice.step[d] = transform.indexToWorld(one) - lattice.origin;
  }
  return lattice;
}

py::tuple arraysOf(Mesh mesh) {
  const py::object colors = mesh.colors.empty() ? py::object(py::none()) : rowsOf(std::move(mesh.colors));
  return py::make_tuple(rowsOf(std::move(mesh.points)), rowsOf(std::move(mesh.triangles)), colors);
}

py::tuple meshOf(const FloatGrid& levelSet, const openvdb::Vec3SGrid* colors, double iso) {
  Mesh mesh;
  {
    const py::gil_scoped_release released;
    mesh = surfaceOf(levelSet, iso);
    if (colors) mesh.colors = colorsAt(*colors, mesh.points);
  }
  return arraysOf(std::move(mesh));
}

void addGrid(py::module_& module) {
  py::class_<PyGrid>(module, "Grid")
      .def_static("_from_numpy", fromNumpy)
      .def_static("_from_bytes", fromBytes)
      .def("_to_bytes", toBytes)
      .def("_to_numpy", toNumpy)
      .def("_to_mesh", toMesh)
      .def_property_readonly("name", [](const PyGrid& g) { return g.grid->getName(); })
      .def_property_readonly("value_type", [](const PyGrid& g) { return g.grid->valueType(); })
      .def_property_readonly(
          "grid_class", [](const PyGrid& g) { return GridBase::gridClassToMenuName(g.grid->getGridClass()); })
      .def_property_readonly("_affine", [](const PyGrid& g) { return affineOf(latticeOf(*g.grid)); })
      .def_property_readonly("box", boxTuple)
      .def_property_readonly("active_voxels", [](const PyGrid& g) { return g.grid->activeVoxelCount(); })
      .def_property_readonly("bytes", [](const PyGrid& g) { return g.grid->memUsage(); });
}

}  // namespace slicemorph

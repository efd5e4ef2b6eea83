#include "tools/python/input.h"

#include "io/image/image_formats.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/job/limit_threads.h"
#include "tools/job/load_settings.h"
#include "tools/python/grid.h"

#include <pybind11/stl.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace slicemorph {
namespace {

using MeshPtr = std::shared_ptr<const StoredMesh>;
using ImagePtr = std::shared_ptr<const ImageFile>;
using FilePtr = std::shared_ptr<const VdbFile>;

/// A name in which nothing means a selection, a number or a placing.
std::string plainlyNamed(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && !std::strchr("._- ", c)) c = '_';
  return name.empty() ? "input" : name;
}

PyInput hold(const std::string& name, Contents contents, std::variant<MeshPtr, ImagePtr, FilePtr> content) {
  const std::string plain = plainlyNamed(name);
  return {plain, std::make_shared<const HeldInput>(HeldInput{heldSpec(plain, contents), std::move(content)})};
}

/// The values of an array i, j, k, in the order of images: i fastest.
template <typename T>
std::vector<T> imageOrder(const py::array& array) {
  const auto* const from = static_cast<const char*>(array.data());
  const py::ssize_t size[] = {array.shape(0), array.shape(1), array.shape(2)},
                    step[] = {array.strides(0), array.strides(1), array.strides(2)};
  std::vector<T> values(size_t(array.size()));
  const py::gil_scoped_release released;
  tbb::parallel_for(py::ssize_t(0), size[2], [&](py::ssize_t k) {
    T* to = values.data() + size_t(k * size[1] * size[0]);
    for (py::ssize_t j = 0; j < size[1]; ++j, to += size[0]) {
      const char* const row = from + k * step[2] + j * step[1];
      if (step[0] == py::ssize_t(sizeof(T))) {
        std::memcpy(to, row, size_t(size[0]) * sizeof(T));
      } else {
        for (py::ssize_t i = 0; i < size[0]; ++i) std::memcpy(to + i, row + i * step[0], sizeof(T));
      }
    }
  });
  return values;
}

ImageValues valuesOf(const py::array& array) {
  const std::string type = py::str(array.dtype().attr("str"));
  if (type == "|u1") return imageOrder<std::uint8_t>(array);
  if (type == "<i2") return imageOrder<std::int16_t>(array);
  if (type == "<u2") return imageOrder<std::uint16_t>(array);
  if (type == "<i4") return imageOrder<std::int32_t>(array);
  if (type == "<f4") return imageOrder<float>(array);
  if (type == "<f8") return imageOrder<double>(array);
  throw InputError("array",
                   "numbers of the type " + type +
                       " are none that images have; there are uint8, int16, uint16, int32, float32, float64");
}

PyInput imageInput(const std::string& name, const py::array& array, const Rows<double>& affine, bool labels) {
  if (array.ndim() != 3 || array.size() == 0)
    throw InputError("array", "expected one of three axes i, j, k with voxels in it, not of " +
                                  std::to_string(array.ndim()) + " axes");
  Image image;
  image.lattice = latticeOf(affine);
  image.lattice.size = {int(array.shape(0)), int(array.shape(1)), int(array.shape(2))};
  image.values = valuesOf(array);
  return inputOf(name, std::move(image), labels);
}

PyInput meshInput(const std::string& name, const Rows<float>& points,
                  const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>& faces,
                  const py::object& colors) {
  const auto mesh = std::make_shared<StoredMesh>();
  mesh->mesh.points = vectorsOf<openvdb::Vec3s>(points, "vertices");
  if (faces.ndim() != 2 || faces.shape(1) < 3)
    throw InputError("faces", "expected an array of N x 3 indices of vertices, or more a face");
  const size_t corners = size_t(faces.shape(1)), count = size_t(faces.shape(0));
  mesh->mesh.faceStarts.clear();
  for (size_t f = 0; f <= count; ++f) mesh->mesh.faceStarts.push_back(std::uint32_t(f * corners));
  for (size_t c = 0; c < count * corners; ++c) {
    const std::int64_t corner = faces.data()[c];
    if (corner < 0 || corner >= std::int64_t(mesh->mesh.points.size()))
      throw InputError("faces", "face " + std::to_string(c / corners) + " has the vertex " +
                                    std::to_string(corner) + " of " +
                                    std::to_string(mesh->mesh.points.size()));
    mesh->mesh.corners.push_back(std::uint32_t(corner));
  }
  if (!colors.is_none()) {
    const auto ofPoints = vectorsOf<openvdb::Vec3s>(Rows<float>(colors), "colors");
    if (ofPoints.size() != mesh->mesh.points.size())
      throw InputError("colors", "expected one for each of " + std::to_string(mesh->mesh.points.size()) +
                                     " vertices, not " + std::to_string(ofPoints.size()));
    for (const std::uint32_t corner : mesh->mesh.corners) mesh->mesh.colors.push_back(ofPoints[corner]);
    mesh->colorsOf = "points";
  }
  mesh->points = mesh->mesh.points.size(), mesh->faces = count;
  return hold(name, Contents::kMesh, MeshPtr(mesh));
}

PyInput gridsInput(const std::string& name, const std::vector<PyGrid>& grids) {
  if (grids.empty()) throw InputError("grids", "expected one at least");
  openvdb::GridPtrVec shared;
  for (const PyGrid& grid : grids)
    shared.push_back(openvdb::ConstPtrCast<openvdb::GridBase>(grid.grid)->copyGrid());
  return hold(name, Contents::kGrids, std::make_shared<const VdbFile>(plainlyNamed(name), shared));
}

/// What can be held is read; sequences, contours and inputs that are placed stay names.
PyInput open(const std::string& text, const GivenOptions& given) {
  const InputSpec spec = parseInput(text);
  const OptionSet options = optionsOf(kConvert, "input", {{text, nullptr}}, given);
  const LoadOptions load = loadSettings(options);
  const bool named = spec.isMoving() || spec.placing.given() || spec.contents == Contents::kContours ||
                     spec.contents == Contents::kSlices;
  CallEvents events;
  return runCall(events, py::none(), [&]() -> PyInput {
    const auto limit = limitThreads(options.values().threads);
    filesOfInput(spec);
    if (named) return {text, nullptr};
    return {text, std::make_shared<const HeldInput>(holdInput(spec, load.image))};
  });
}

std::string kindOf(const PyInput& input) {
  const Contents contents = input.held ? input.held->spec.contents : parseInput(input.name).contents;
  if (!input.held && parseInput(input.name).isMoving()) return "sequence";
  switch (contents) {
    case Contents::kMesh:
      return "mesh";
    case Contents::kGrids:
      return "grids";
    case Contents::kImage:
      return "image";
    case Contents::kContours:
      return "contours";
    case Contents::kSlices:
      return "slices";
    default:
      return "unknown";
  }
}

const HeldInput& inMemory(const PyInput& input, const char* what) {
  if (input.held) return *input.held;
  throw InputError(input.name, std::string("is only named, not read, and has no ") + what +
                                   " of its own; load one still file, without braces");
}

const ImagePtr& imageIn(const PyInput& input) {
  const HeldInput& held = inMemory(input, "voxels");
  if (const auto* image = std::get_if<ImagePtr>(&held.content)) return *image;
  throw InputError(input.name, "is no image");
}

py::array voxelsOf(const PyInput& input) {
  const ImagePtr& file = imageIn(input);
  const openvdb::Coord& size = file->image.lattice.size;
  return std::visit(
      [&](const auto& values) -> py::array {
        const py::ssize_t one = sizeof(values[0]), row = one * size[0], slice = row * size[1];
        return arrayOf(file, values.data(), {size[0], size[1], size[2]}, {one, row, slice});
      },
      file->image.values);
}

std::vector<PyGrid> gridsIn(const PyInput& input) {
  const HeldInput& held = inMemory(input, "grids");
  const auto* const file = std::get_if<FilePtr>(&held.content);
  if (!file) throw InputError(input.name, "holds no grids");
  std::vector<PyGrid> grids;
  const py::gil_scoped_release released;
  for (size_t i = 0; i < (*file)->entries().size(); ++i)
    if (held.spec.selection.empty() || (*file)->entries()[i].name == held.spec.selection)
      grids.push_back({(*file)->read(i)});
  return grids;
}

/// The shape as a level set, its colours or none, and notes.
py::tuple shapeOf(const PyInput& input, const GivenOptions& given) {
  const OptionSet options = optionsOf(kConvert, "input", {input}, given);
  const LoadOptions load = loadSettings(options);
  CallEvents events;
  LoadedObject loaded = runCall(events, py::none(), [&] {
    const auto limit = limitThreads(options.values().threads);
    return input.held ? loadObject(*input.held, load) : loadObject(input.name, load);
  });
  const py::object colors = loaded.colors ? py::cast(PyGrid{loaded.colors}) : py::object(py::none());
  return py::make_tuple(PyGrid{loaded.object.levelSet}, colors, loaded.notes);
}

py::tuple shapeMesh(const PyGrid& shape, const py::object& colors) {
  const auto ofSurface =
      colors.is_none() ? nullptr : openvdb::GridBase::grid<openvdb::Vec3SGrid>(colors.cast<PyGrid>().grid);
  return meshOf(*openvdb::GridBase::grid<FloatGrid>(shape.grid), ofSurface.get());
}

/// The triangles of a mesh as it was given; faces of more corners as fans.
py::tuple ownMesh(const PyInput& input) {
  const HeldInput& held = inMemory(input, "faces");
  const auto* const stored = std::get_if<MeshPtr>(&held.content);
  if (!stored) throw InputError(input.name, "is no mesh");
  const PolygonMesh& mesh = (*stored)->mesh;
  Mesh triangles;
  triangles.points = mesh.points;
  for (openvdb::Vec3s& p : triangles.points) p = openvdb::Vec3s(Vec3d(p) + (*stored)->origin);
  for (size_t f = 0; f < mesh.faceCount(); ++f)
    for (std::uint32_t c = mesh.faceStarts[f] + 1; c + 1 < mesh.faceStarts[f + 1]; ++c)
      triangles.triangles.emplace_back(mesh.corners[mesh.faceStarts[f]], mesh.corners[c],
                                       mesh.corners[c + 1]);
  return arraysOf(std::move(triangles));
}

/// Grids as .vdb or .nvdb, an image as an image file.
void save(const PyInput& input, const std::string& path) {
  const HeldInput& held = inMemory(input, "content");
  CallEvents events;
  if (const auto* file = std::get_if<FilePtr>(&held.content)) {
    openvdb::GridCPtrVec grids;
    for (const PyGrid& grid : gridsIn(input)) grids.push_back(grid.grid);
    VdbOutput options;
    options.metadata = (*file)->metadata(), options.compression = (*file)->compression();
    return runCall(events, py::none(), [&] { writeGridFile(path, grids, options); });
  }
  const ImagePtr& image = imageIn(input);
  runCall(events, py::none(), [&] { writeImage(path, image->image); });
}

}  // namespace

PyInput inputOf(const std::string& name, Image image, bool labels) {
  const auto file = std::make_shared<ImageFile>();
  file->image = std::move(image), file->name = plainlyNamed(name), file->format = "memory";
  if (labels) file->notes.emplace_back(kLabelsStated, Severity::kDetail, "", "was said to hold labels");
  return hold(name, Contents::kImage, ImagePtr(file));
}

OptionSet optionsOf(Command command, const std::string& row, const std::vector<PyInput>& inputs,
                    const GivenOptions& given) {
  initialiseVdb();
  OptionSet options(command);
  std::vector<std::string> names;
  HeldInputs held;
  for (const PyInput& input : inputs) names.push_back(input.name), held.push_back(input.held);
  options.set(options.row(row), names);
  options.hold(std::move(held));
  for (const auto& [name, texts] : given)
    name == kTablesName ? options.holdJobFile(name, texts.at(0)) : options.set(options.row(name), texts);
  return options;
}

void addInput(py::module_& module) {
  py::class_<PyInput>(module, "Input")
      .def_static("_image", imageInput)
      .def_static("_mesh", meshInput)
      .def_static("_grids", gridsInput)
      .def_static("_open", open)
      .def_static("_named",
                  [](const std::string& text) {
                    return PyInput{text, nullptr};
                  })
      .def("_voxels", voxelsOf)
      .def("_grids_in", gridsIn)
      .def("_shape", shapeOf)
      .def("_own_mesh", ownMesh)
      .def("_save", save)
      .def("_affine", [](const PyInput& input) { return affineOf(imageIn(input)->image.lattice); })
      .def("_notes",
           [](const PyInput& input) {
             const auto* image = input.held ? std::get_if<ImagePtr>(&input.held->content) : nullptr;
             return image ? (*image)->notes : Notes();
           })
      .def_property_readonly("name", [](const PyInput& input) { return input.name; })
      .def_property_readonly("kind", kindOf);
  module.def("_shape_mesh", shapeMesh);
}

}  // namespace slicemorph

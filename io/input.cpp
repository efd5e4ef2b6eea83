#include "io/input.h"

#include "engine/errors.h"
#include "engine/volume/level_set.h"
#include "engine/volume/voxelise.h"
#include "io/grid_choice.h"
#include "io/mesh_reader.h"
#include "io/paths.h"
#include "io/vdb_reader.h"

#include <cmath>
#include <filesystem>
#include <sstream>

namespace slicemorph {
namespace {

constexpr int kDefaultResolution = 256, kLeastResolution = 8, kMostResolution = 4096;

void checkOptions(const LoadOptions& options) {
  std::ostringstream why;
  if (!(options.voxelSize >= 0) || !std::isfinite(options.voxelSize)) {
    why << "voxel size " << options.voxelSize << " is no positive number of world units";
  } else if (options.resolution != 0 &&
             (options.resolution < kLeastResolution || options.resolution > kMostResolution)) {
    why << "resolution " << options.resolution << " is out of range: use " << kLeastResolution << " to "
        << kMostResolution << " voxels along the longest side";
  } else if (options.voxelSize > 0 && options.resolution != 0) {
    why << "both a voxel size (" << options.voxelSize << ") and a resolution (" << options.resolution
        << ") are given: use one of them";
  } else if (!std::isfinite(options.iso)) {
    why << "the iso value is not finite";
  }
  if (!why.str().empty()) throw InputError(why.str());
}

double voxelSizeFor(const Mesh& mesh, int resolution) {
  openvdb::BBoxd box;
  for (const openvdb::Vec3s& p : mesh.points) box.expand(Vec3d(p));
  return box.extents()[int(box.maxExtent())] / resolution;
}

LoadedObject loadMesh(const std::string& path, const LoadOptions& options) {
  RepairedMesh repaired = closeSurface(path, readPolygons(path));
  const int resolution = options.resolution ? options.resolution : kDefaultResolution;
  LoadedObject loaded;
  loaded.object.levelSet =
      voxelise(repaired.mesh, options.voxelSize > 0 ? options.voxelSize : voxelSizeFor(repaired.mesh, resolution));
  loaded.notes = std::move(repaired.notes);
  return loaded;
}

/// World units; 0 keeps the grid's own.
double voxelSizeFor(const FloatGrid& grid, const LoadOptions& options) {
  const LevelSetReading reading = readingOf(grid, 0, options.iso);
  const bool limited = reading.fog && options.fogResolution > 0 && options.voxelSize == 0;
  if (!options.resolution && !limited) return options.voxelSize;
  if (!reading.problem.empty()) throw GeometryError(reading.problem);
  if (options.resolution) return voxelSizeFor(surfaceAsRead(grid, reading), options.resolution);
  const openvdb::BBoxd box = grid.transform().indexToWorld(grid.evalActiveVoxelBoundingBox());
  return std::max(box.extents()[int(box.maxExtent())] / options.fogResolution, grid.voxelSize()[0]);
}

LoadedObject loadGrid(const FloatGrid::ConstPtr& grid, const LoadOptions& options) {
  LevelSetInput input = toLevelSet(grid, voxelSizeFor(*grid, options), options.iso);
  LoadedObject loaded;
  loaded.object.levelSet = input.grid;
  loaded.halfFloat = grid->saveFloatAsHalf();
  loaded.notes = std::move(input.notes);
  loaded.fog = input.fog;
  return loaded;
}

LoadedObject loadVdb(const InputName& name, const LoadOptions& options) {
  const auto opened = std::make_shared<const VdbFile>(name.path);
  const VdbFile& file = *opened;
  const bool named = !name.grid.empty();
  std::string passedOver;
  for (size_t index : named ? std::vector<size_t>{findGrid(file, name)} : gridsToTry(file, name.path)) {
    const std::string grid = file.entries()[index].name;
    try {
      LoadedObject loaded = loadGrid(asFloatGrid(file.read(index)), options);
      loaded.file = opened;
      loaded.grid = index;
      loaded.named = named;
      if (!named && file.entries().size() > 1) {
        loaded.notes.insert(loaded.notes.begin(), "took grid '" + grid + "' of " +
                                                      std::to_string(file.entries().size()) + passedOver);
      }
      return loaded;
    } catch (const GeometryError& error) {
      if (named) throw GeometryError("grid '" + grid + "': " + error.what());
      passedOver += "; '" + grid + "' is no shape: " + error.what();
    }
  }
  throw GeometryError("no grid is a shape" + passedOver);
}

/// The engine does not know the file's name: it is put in front where a message lacks it.
template <typename Error>
[[noreturn]] void rethrow(const std::string& path, const Error& error) {
  const std::string what = error.what();
  throw Error(what.find(path) == std::string::npos ? path + ": " + what : what);
}

}  // namespace

LoadedObject loadObject(const std::string& input, const LoadOptions& options) {
  initialiseVdb();
  const InputName name = splitInput(input);
  const std::string extension = extensionOf(name.path);
  try {
    checkOptions(options);
    if (extension != ".vdb" && !isMeshExtension(extension)) {
      sizeOfInput(name.path);  // a missing file or a folder is the better message
      throw InputError(name.path + ": cannot read the extension '" + extension +
                       "'; use .vdb, .obj, .ply, .stl, .off or .glb");
    }
    LoadedObject loaded = extension == ".vdb" ? loadVdb(name, options) : loadMesh(name.path, options);
    loaded.object.name = std::filesystem::path(name.path).stem().string();
    return loaded;
  } catch (const GeometryError& error) {
    rethrow(name.path, error);
  } catch (const InputError& error) {
    rethrow(name.path, error);
  } catch (const std::bad_alloc&) {
    throw IoError(name.path + " cannot be read: there is not enough memory; use a larger voxel size");
  }
}

}  // namespace slicemorph

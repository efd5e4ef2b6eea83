#include "io/input.h"

#include "engine/volume/image_shape.h"
#include "engine/volume/level_set.h"
#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "io/mesh/mesh_reader.h"
#include "io/paths.h"
#include "io/sequence.h"
#include "io/vdb/grid_choice.h"
#include "io/vdb/vdb_reader.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
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
  const StoredMesh stored = readPolygons(path);
  RepairedMesh repaired = closeSurface(path, stored);
  const int resolution = options.resolution ? options.resolution : kDefaultResolution;
  LoadedObject loaded;
  loaded.object.levelSet = voxelise(
      repaired.mesh, options.voxelSize > 0 ? options.voxelSize : voxelSizeFor(repaired.mesh, resolution));
  loaded.notes = std::move(repaired.notes);
  loaded.colors = colorsAround(*loaded.object.levelSet, stored.mesh);
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

/// Null where the file has none.
openvdb::Vec3SGrid::ConstPtr colorsBeside(const VdbFile& file, const FloatGrid& levelSet) {
  const std::optional<size_t> index = findColors(file);
  if (!index) return nullptr;
  const openvdb::Vec3SGrid::ConstPtr colors = asColorGrid(file.read(*index));
  return colors ? colorsAround(levelSet, *colors) : nullptr;
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
      if (!loaded.fog) loaded.colors = colorsBeside(file, *loaded.object.levelSet);
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

/// Of a level set of an image's shape, world units.
double voxelSizeFor(const Image& image, const FloatGrid& shape, const LoadOptions& options) {
  if (options.voxelSize > 0) return options.voxelSize;
  const openvdb::BBoxd box = shape.transform().indexToWorld(shape.evalActiveVoxelBoundingBox());
  const double longest = box.extents()[int(box.maxExtent())];
  if (options.resolution) return longest / options.resolution;
  const Vec3d spacing = image.lattice.spacing();
  return std::max(std::min({spacing[0], spacing[1], spacing[2]}), longest / kDefaultResolution);
}

FloatGrid::Ptr levelSetOf(const FloatGrid::Ptr& shape, double iso, double voxelSize) {
  return toLevelSet(shape, voxelSize, iso).grid;
}

LoadedObject loadImage(const std::string& input, const LoadOptions& options) {
  ImageFile file = readImage(input, options.image);
  LoadedObject loaded;
  loaded.notes = std::move(file.notes);
  loaded.image = std::make_shared<const Image>(std::move(file.image));
  const Image& image = *loaded.image;
  const bool isoGiven = options.isoGiven || options.iso != 0;
  loaded.labels = options.imageKind == ImageKind::kLabels ||
                  (options.imageKind == ImageKind::kAuto && !isoGiven && looksLikeLabels(image));
  if (loaded.labels) {
    const size_t count = labelsOf(image).size();
    if (count == 0) throw GeometryError("the label map is empty: every voxel is 0");
    loaded.notes.push_back(
        "read as a map of " + std::to_string(count) + (count == 1 ? " label" : " labels") +
        (options.imageKind == ImageKind::kAuto ? " (--image grey reads grey values)" : ""));
    const FloatGrid::Ptr shape = shapeOfLabels(image);
    loaded.object.levelSet = levelSetOf(shape, 0.5, voxelSizeFor(image, *shape, options));
    return loaded;
  }
  const double iso = loaded.iso = isoGiven ? options.iso : otsuValue(image);
  const FloatGrid::Ptr shape = shapeAbove(image, iso);
  const double voxelSize = voxelSizeFor(image, *shape, options);
  loaded.object.levelSet = levelSetOf(shape, iso, voxelSize);
  for (double further : options.furtherIsos)
    loaded.object.inner.push_back(levelSetOf(shapeAbove(image, further), further, voxelSize));
  if (!isoGiven) {
    std::ostringstream note;
    note << "its shape is what is above " << iso << " (found from its values; --iso sets another)";
    loaded.notes.push_back(note.str());
  }
  return loaded;
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
    if (isImageInput(input)) {
      LoadedObject loaded = loadImage(input, options);
      loaded.object.name = input;
      return loaded;
    }
    if (extension != ".vdb" && !isMeshExtension(extension)) {
      sizeOfInput(name.path);  // a missing file or a folder is the better message
      throw InputError(name.path + ": cannot read the extension '" + extension +
                       "'; use .vdb, .obj, .ply, .stl, .off, .glb, or an image: .nii .nii.gz .nrrd .nhdr "
                       ".mha .mhd, a DICOM "
                       "folder, name.####.tif|png|exr");
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

LoadOptions optionsOfInput(const LoadOptions& options, size_t input) {
  LoadOptions own = options;
  if (options.isosByInput.empty()) return own;
  const std::vector<double>& isos = options.isosByInput.at(input);
  own.iso = isos[0];
  own.furtherIsos.assign(isos.begin() + 1, isos.end());
  return own;
}

void addLabelSurfaces(std::vector<LoadedObject>& objects) {
  constexpr size_t kMost = 24;
  std::map<std::int64_t, std::pair<size_t, double>>
      found;  // per label: objects that have it, its volume in them
  for (const LoadedObject& object : objects) {
    if (!object.labels) return;
    std::map<std::int64_t, size_t> counts;
    std::visit(
        [&](const auto& values) {
          for (const auto v : values)
            if (v != 0) ++counts[std::int64_t(v)];
        },
        object.image->values);
    const ImageLattice& lattice = object.image->lattice;
    const double voxel = std::abs(lattice.step[0].dot(lattice.step[1].cross(lattice.step[2])));
    for (const auto& [label, count] : counts)
      ++found[label].first, found[label].second += double(count) * voxel;
  }
  if (found.size() < 2) return;  // the shape itself
  std::vector<std::pair<double, std::int64_t>> shared;
  for (const auto& [label, about] : found)
    if (about.first > 1) shared.emplace_back(-about.second, label);
  std::sort(shared.begin(), shared.end());
  shared.resize(std::min(shared.size(), kMost));
  for (LoadedObject& object : objects) {
    const std::vector<std::int64_t> own = labelsOf(*object.image);
    object.object.inner.assign(shared.size(), nullptr);
    const double voxelSize = object.object.levelSet->voxelSize()[0];
    tbb::parallel_for(size_t(0), shared.size(), [&](size_t n) {
      if (!std::binary_search(own.begin(), own.end(), shared[n].second)) return;
      try {
        object.object.inner[n] = levelSetOf(shapeOfLabel(*object.image, shared[n].second), 0.5, voxelSize);
      } catch (const GeometryError&) {  // too thin for the voxel size: it goes along with the others
      }
    });
  }
}

bool isMovingInput(const std::string& input) { return isSequenceInput(input) && !isImageInput(input); }

std::vector<std::string> filesOfInput(const std::string& input) {
  namespace fs = std::filesystem;
  std::vector<std::string> files;
  if (isSequenceInput(input)) {
    for (const SequenceFile& file : findSequence(splitSequenceInput(input).path)) files.push_back(file.path);
  } else {
    const std::string path = isImageInput(input) ? splitImageInput(input).path : splitInput(input).path;
    std::error_code error;
    if (isImageInput(input) && fs::is_directory(path, error)) {
      for (const auto& entry : fs::directory_iterator(path, error))
        if (entry.is_regular_file()) files.push_back(entry.path().string());
      if (error || files.empty()) throw IoError(path + ": no files in this folder");
      std::sort(files.begin(), files.end());
      return files;
    }
    files.push_back(path);
  }
  for (const std::string& file : files) sizeOfInput(file);
  return files;
}

}  // namespace slicemorph

#include "slicemorph/io/input.h"

#include "engine/numerics/readable.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/level_set.h"
#include "engine/volume/mesh_measures.h"
#include "engine/volume/seed.h"
#include "engine/volume/strays.h"
#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "io/format.h"
#include "io/held_input.h"
#include "io/image/image_formats.h"
#include "io/image/label_values.h"
#include "io/mesh/mesh_reader.h"
#include "io/vdb/grid_choice.h"
#include "io/vdb/vector_parts.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

namespace slicemorph {
namespace {

/// Voxels along the longest side: the default, and the range that is accepted.
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
  } else if (!(options.shell >= 0) || !std::isfinite(options.shell)) {
    why << "--shell " << options.shell << " is no positive thickness in world units";
  } else if (!std::isfinite(options.iso)) {
    why << "the iso value is not finite";
  }
  if (!why.str().empty()) throw InputError(why.str());
}

double longestSide(const Mesh& mesh) {
  const openvdb::BBoxd box = boundsOf(mesh.points);
  return box.extents()[int(box.maxExtent())];
}

Placing placingFor(const InputSpec& input, const LoadOptions& options) {
  return options.placing.after(placingOf(input.placing, options.image.up));
}

/// Bytes that voxelising takes for each voxel of the narrow band: 37 to 40 were measured on balls at 512 and 1024
/// voxels.
constexpr double kBandVoxelBytes = 30;

/// Throws MemoryError where the narrow band around a mesh would not fit.
void requireForBand(const SolidMesh& solid, double voxelSize, const MemoryLimit& limit) {
  const double voxels = bandVoxelsOf(areaOf(solid.mesh) + areaOf(solid.sheets), voxelSize),
               bytes = voxels * kBandVoxelBytes;
  if (!(bytes > limit.left()) || voxels > kMostBandVoxels) return;
  std::ostringstream what, advice;
  what << "a grid with voxels of " << voxelSize << " and " << readableCount(voxels)
       << " of these around the surface";
  advice << "use a --voxel-size of at least " << voxelSize * std::sqrt(bytes / std::max(limit.left(), 1.0));
  limit.require(bytes, "", what.str(), advice.str());
}

LoadedObject loadMesh(StoredMesh stored, const InputSpec& input, const LoadOptions& options) {
  if (stored.mesh.points.empty() && stored.mesh.faceCount() == 0)
    throw NothingError(input.path, "holds no points and no faces: it is empty");
  // What lies far away keeps its digits: only its grids are moved to its place.
  const Placing placing = placingFor(input, options);
  const bool far = stored.origin != Vec3d(0.0);
  const Placing ofGrids{1, Mat3d::identity(), far ? placing(stored.origin) : Vec3d(0.0)};
  place(stored.mesh.points, far ? Placing{placing.scale, placing.rotation} : placing);
  SolidOptions wanted;
  wanted.voxelSize = options.voxelSize, wanted.shell = options.shell;
  wanted.resolution = options.resolution ? options.resolution : kDefaultResolution;
  MeshSolid solid = solidOfFile(input.path, stored, wanted, [&](const SolidMesh& mesh) {
    requireForBand(mesh, voxelSizeOf(mesh, wanted), options.memory);
  });
  const openvdb::Vec3SGrid::Ptr colors = colorsAround(*solid.levelSet, stored.mesh);
  LoadedObject loaded;
  loaded.object.levelSet = openvdb::GridBase::grid<FloatGrid>(placed(solid.levelSet, ofGrids));
  loaded.notes = std::move(solid.notes);
  loaded.colors = openvdb::GridBase::grid<openvdb::Vec3SGrid>(placed(colors, ofGrids));
  return loaded;
}

/// Voxel size of the level set of a grid, world units; 0: the grid's own.
double voxelSizeFor(const FloatGrid& grid, const LoadOptions& options) {
  const LevelSetReading reading = readingOf(grid, 0, options.iso);
  const bool limited = reading.fog && options.fogResolution > 0 && options.voxelSize == 0;
  if (!options.resolution && !limited) return options.voxelSize;
  if (!reading.problem.empty()) throw GeometryError(reading.problem);
  if (options.resolution) return longestSide(surfaceAsRead(grid, reading)) / options.resolution;
  const openvdb::BBoxd box = grid.transform().indexToWorld(findStrays(grid).body);
  return std::max(box.extents()[int(box.maxExtent())] / options.fogResolution, grid.voxelSize()[0]);
}

LoadedObject loadGrid(const FloatGrid::ConstPtr& grid, const LoadOptions& options) {
  LevelSetInput input = toLevelSet(grid, voxelSizeFor(*grid, options), options.iso);
  LoadedObject loaded;
  loaded.object.levelSet = input.grid;
  loaded.halfFloat = grid->saveFloatAsHalf();
  loaded.notes = std::move(input.notes);
  loaded.fog = input.fog;
  if (options.density && loaded.fog) loaded.object.density = grid;
  return loaded;
}

/// Takes out of a shape what lies so far away that the rest would be too small for the matching.
void leaveOutStrays(LoadedObject& loaded) {
  const Strays strays = findStrays(*loaded.object.levelSet);
  if (strays.leaves.empty()) return;
  loaded.object.levelSet = withoutStrays(*loaded.object.levelSet, strays);
  std::ostringstream note;
  note << strays.pieces << (strays.pieces == 1 ? " piece, " : " pieces, ") << 100 * strays.share
       << " % of it, " << (strays.pieces == 1 ? "lies" : "lie") << " many times its size away and "
       << (strays.pieces == 1 ? "takes" : "take") << " no part in the matching"
       << (loaded.fog ? "" : ": left out");
  loaded.notes.emplace_back("volume.strays", loaded.fog ? Severity::kNote : Severity::kWarning, "",
                            note.str());
}

/// Whether a grid has no active voxels, or none within its surface.
bool holdsNothing(const FloatGrid& grid, const LoadOptions& options) {
  if (grid.activeVoxelCount() == 0) return true;
  const LevelSetReading reading = readingOf(grid, 0, options.iso);
  if (reading.problem.empty() || !std::isfinite(reading.minimum) || !std::isfinite(reading.maximum))
    return false;
  return reading.fog ? reading.maximum <= reading.iso : reading.minimum >= reading.iso;
}

/// Colours around the level set from a colour grid of the file; null where it has none.
openvdb::Vec3SGrid::ConstPtr colorsBeside(const VdbFile& file, const FloatGrid& levelSet,
                                          const Placing& placing) {
  const std::optional<size_t> index = findColors(file);
  if (!index) return nullptr;
  const openvdb::Vec3SGrid::ConstPtr colors = asColorGrid(placed(file.read(*index), placing));
  return colors ? colorsAround(levelSet, *colors) : nullptr;
}

/// Throws MemoryError where a grid that states its size in memory would not fit.
void requireForGrid(const VdbFile& file, size_t index, const MemoryLimit& limit) {
  const openvdb::GridBase::ConstPtr header = file.readHeader(index);
  const auto bytes = header->getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_MEM_BYTES);
  if (bytes)
    limit.require(double(bytes->value()), "", "grid '" + file.entries()[index].name + "'",
                  "write it with larger voxels, or let the program take more");
}

LoadedObject loadCandidate(const std::shared_ptr<const VdbFile>& file, size_t index, const Placing& placing,
                           const LoadOptions& options) {
  requireForGrid(*file, index, options.memory);
  const openvdb::GridBase::Ptr stored = placed(file->read(index), placing);
  const FloatGrid::ConstPtr grid = asFloatGrid(stored);
  LoadedObject loaded;
  try {
    loaded = loadGrid(grid, options);
  } catch (const GeometryError& error) {
    if (holdsNothing(*grid, options)) throw NothingError(error.what());
    throw;
  }
  loaded.file = file;
  loaded.grid = index;
  loaded.gridName = plainName(file->entries()[index]);
  loaded.doubles = stored->isType<openvdb::DoubleGrid>();
  if (!loaded.fog) loaded.colors = colorsBeside(*file, *loaded.object.levelSet, placing);
  return loaded;
}

Note noteOnChoice(const VdbFile& file, const GridCandidate& taken, const std::string& passedOver) {
  return {"vdb.grid-chosen", Severity::kNote, "",
          "took grid '" + file.entries()[taken.index].name + "' of " + std::to_string(file.entries().size()) +
              ", " + taken.why + passedOver};
}

/// Tries the candidates; what is static only where there is nothing else.
LoadedObject loadUnnamed(const std::shared_ptr<const VdbFile>& file, const InputSpec& input,
                         const LoadOptions& options) {
  std::string passedOver;
  bool onlyNothing = true;
  const std::vector<GridCandidate> candidates = gridCandidates(*file, input.path, options.besides);
  for (const GridCandidate& candidate : candidates) {
    if (candidate.isStatic && (options.movingOnly || !candidates[0].isStatic)) break;
    const std::string grid = file->entries()[candidate.index].name;
    try {
      LoadedObject loaded = loadCandidate(file, candidate.index, placingFor(input, options), options);
      if (file->entries().size() > 1)
        loaded.notes.insert(loaded.notes.begin(), noteOnChoice(*file, candidate, passedOver));
      return loaded;
    } catch (const GeometryError& error) {
      onlyNothing = onlyNothing && dynamic_cast<const NothingError*>(&error);
      passedOver += "; '" + grid + std::string("' is no shape: ") + error.what();
    }
  }
  if (candidates.back().isStatic && !candidates[0].isStatic)
    passedOver += "; what stands still is taken where it is named, " + input.path + ":" +
                  file->entries()[candidates.back().index].name;
  if (onlyNothing) throw NothingError("no grid is a shape" + passedOver);
  throw GeometryError("no grid is a shape" + passedOver);
}

LoadedObject loadShape(const std::shared_ptr<const VdbFile>& file, const InputSpec& input,
                       const LoadOptions& options) {
  if (input.selection.empty()) return loadUnnamed(file, input, options);
  const size_t index = findGrid(*file, input);
  const std::string about = input.path + ": grid '" + file->entries()[index].name + "'";
  try {
    LoadedObject loaded = loadCandidate(file, index, placingFor(input, options), options);
    loaded.named = true;
    return loaded;
  } catch (const NothingError& error) {
    throw NothingError(about, error.what());
  } catch (const GeometryError& error) {
    throw GeometryError(about, error.what());
  }
}

LoadedObject loadVdb(const std::shared_ptr<const VdbFile>& file, const InputSpec& input,
                     const LoadOptions& options) {
  LoadedObject loaded = loadShape(file, input, options);
  if (!loaded.object.density) return loaded;
  if (const openvdb::GridBase::Ptr velocity = readVelocity(*file))
    loaded.object.velocity =
        openvdb::gridConstPtrCast<openvdb::Vec3SGrid>(placed(velocity, placingFor(input, options)));
  return loaded;
}

/// Voxel size of the level set of an image's shape, world units.
double voxelSizeFor(const Image& image, const FloatGrid& shape, const LoadOptions& options) {
  if (options.voxelSize > 0) return options.voxelSize;
  const openvdb::BBoxd box = shape.transform().indexToWorld(shape.evalActiveVoxelBoundingBox());
  const double longest = box.extents()[int(box.maxExtent())];
  if (options.resolution) return longest / options.resolution;
  const Vec3d spacing = image.lattice.spacing();
  return std::max(std::min({spacing[0], spacing[1], spacing[2]}), longest / kDefaultResolution);
}

LoadedObject loadLabels(LoadedObject loaded, const LoadOptions& options) {
  const Image& image = *loaded.image;
  const size_t count = labelsOf(image).size();
  if (count == 0) throw GeometryError("the label map is empty: every voxel is 0");
  loaded.labels = true;
  loaded.notes.emplace_back(
      "image.read-as-labels", Severity::kNote, "",
      "read as a map of " + std::to_string(count) + (count == 1 ? " label" : " labels") +
          (options.imageKind == ImageKind::kAuto ? " (--image grey reads grey values)" : ""));
  const FloatGrid::Ptr shape = shapeOfLabels(image);
  loaded.object.levelSet = levelSetOf(shape, 0.5, voxelSizeFor(image, *shape, options));
  return loaded;
}

LoadedObject loadImage(ImageFile file, const LoadOptions& options) {
  const bool stated = isStatedLabels(file);
  LoadedObject loaded;
  loaded.notes = std::move(file.notes);
  loaded.imageHeader = std::move(file.header);
  place(file.image.lattice, options.placing);
  if (!options.placing.isIdentity()) loaded.imageHeader.forms.reset();
  const bool isoGiven = options.isoGiven || options.iso != 0;
  if (options.imageKind == ImageKind::kLabels || (options.imageKind == ImageKind::kAuto && !isoGiven))
    takeLabels(file.image, options.imageKind == ImageKind::kLabels, loaded.notes);
  loaded.image = std::make_shared<const Image>(std::move(file.image));
  const Image& image = *loaded.image;
  const bool labels =
      options.imageKind == ImageKind::kLabels ||
      (options.imageKind == ImageKind::kAuto && !isoGiven && (stated || looksLikeLabels(image)));
  if (labels) return loadLabels(std::move(loaded), options);
  const double iso = loaded.iso = isoGiven ? options.iso : otsuValue(image);
  const FloatGrid::Ptr shape = shapeAbove(image, iso);
  const double voxelSize = voxelSizeFor(image, *shape, options);
  loaded.object.levelSet = levelSetOf(shape, iso, voxelSize);
  for (double further : options.furtherIsos)
    loaded.object.inner.push_back(levelSetOf(shapeAbove(image, further), further, voxelSize));
  if (!isoGiven) {
    std::ostringstream note;
    note << "its shape is what is above " << iso << " (found from its values; --iso sets another)";
    loaded.notes.emplace_back("image.iso-found", Severity::kNote, "", note.str());
  }
  return loaded;
}

std::map<std::int64_t, size_t> voxelsByLabel(const Image& image) {
  std::map<std::int64_t, size_t> counts;
  std::visit(
      [&](const auto& values) {
        for (const auto v : values)
          if (v != 0) ++counts[std::int64_t(v)];
      },
      image.values);
  return counts;
}

/// Labels that more than one of the maps has, by total volume, the largest first. None where all maps have
/// one and the same label: it is the shape itself.
std::vector<std::int64_t> sharedLabels(const std::vector<LoadedObject>& objects) {
  // Every surface takes part in the matching: more of them cost time and do not steer it better.
  constexpr size_t kMostLabelSurfaces = 24;
  struct Found {
    size_t objects = 0;
    double volume = 0;
  };
  std::map<std::int64_t, Found> found;
  for (const LoadedObject& object : objects) {
    const ImageLattice& lattice = object.image->lattice;
    const double voxel = std::abs(lattice.step[0].dot(lattice.step[1].cross(lattice.step[2])));
    for (const auto& [label, count] : voxelsByLabel(*object.image))
      ++found[label].objects, found[label].volume += double(count) * voxel;
  }
  std::vector<std::pair<double, std::int64_t>> shared;
  for (const auto& [label, about] : found)
    if (about.objects > 1 && found.size() > 1) shared.emplace_back(-about.volume, label);
  std::sort(shared.begin(), shared.end());
  shared.resize(std::min(shared.size(), kMostLabelSurfaces));
  std::vector<std::int64_t> labels;
  labels.reserve(shared.size());
  for (const auto& [volume, label] : shared) labels.push_back(label);
  return labels;
}

/// `held`: the input where it is in memory; null: it is read.
LoadedObject load(const InputSpec& input, const HeldInput* held, const LoadOptions& options) {
  checkOptions(options);
  LoadedObject loaded;
  switch (input.contents) {
    case Contents::kImage:
      loaded = loadImage(
          held ? *std::get<std::shared_ptr<const ImageFile>>(held->content) : readImage(input, options.image),
          options);
      loaded.object.name = input.text;
      loaded.placing = placingFor(input, options);
      return loaded;
    case Contents::kGrids:
      loaded = loadVdb(held ? std::get<std::shared_ptr<const VdbFile>>(held->content)
                            : std::make_shared<const VdbFile>(input.path),
                       input, options);
      break;
    case Contents::kMesh:
      loaded =
          loadMesh(held ? *std::get<std::shared_ptr<const StoredMesh>>(held->content) : readPolygons(input),
                   input, options);
      break;
    default:
      refuseAsShape(input);
  }
  loaded.object.name = std::filesystem::path(input.path).stem().string();
  loaded.placing = placingFor(input, options);
  if (options.matching) leaveOutStrays(loaded);
  return loaded;
}

/// Adds the file's name to errors of the engine, which does not know it.
template <typename Error>
[[noreturn]] void rethrow(const std::string& path, const Error& error) {
  if (!error.note().about.empty()) throw error;
  throw Error(path, error.note().text);
}

LoadedObject loadNamed(const InputSpec& input, const HeldInput* held, const LoadOptions& options) {
  initialiseVdb();
  try {
    return load(input, held, options);
  } catch (const NothingError& error) {
    rethrow(input.path, error);
  } catch (const GeometryError& error) {
    rethrow(input.path, error);
  } catch (const InputError& error) {
    rethrow(input.path, error);
  } catch (const MemoryError& error) {
    rethrow(input.path, error);
  } catch (const std::bad_alloc&) {
    throw MemoryError(input.path, "cannot be read: there is not enough memory; use a larger --voxel-size");
  }
}

}  // namespace

LoadedObject loadObject(const InputSpec& input, const LoadOptions& options) {
  return loadNamed(stillInput(input), nullptr, options);
}

LoadedObject loadObject(const HeldInput& input, const LoadOptions& options) {
  return loadNamed(input.spec, &input, options);
}

InputSpec heldSpec(const std::string& name, Contents contents) {
  InputSpec spec;
  spec.text = spec.path = name;
  spec.contents = contents;
  return spec;
}

HeldInput holdInput(const InputSpec& given, const ImageOptions& options) {
  initialiseVdb();
  const InputSpec input = stillInput(given);
  if (input.contents == Contents::kImage)
    return {input, std::make_shared<const ImageFile>(readImage(input, options))};
  if (input.contents == Contents::kGrids) return {input, std::make_shared<const VdbFile>(input.path)};
  if (input.contents == Contents::kMesh)
    return {input, std::make_shared<const StoredMesh>(readPolygons(input))};
  refuseAsShape(input);
}

LoadedObject loadObject(const std::string& text, const LoadOptions& options) {
  return loadObject(parseInput(text), options);
}

std::string surfaceNameOf(const std::vector<LoadedObject>& inputs) {
  for (const LoadedObject& input : inputs)
    if (input.file && !input.fog && !input.gridName.empty()) return input.gridName;
  return "surface";
}

LoadedObject asNothing(const LoadedObject& piece, const InputSpec& file) {
  LoadedObject nothing = piece;
  nothing.nothing = true;
  nothing.notes.clear();
  nothing.colors = nullptr;
  if (!piece.fog) nothing.object.levelSet = seedIn(*piece.object.levelSet);
  nothing.object.inner.clear(), nothing.object.density = nullptr, nothing.object.velocity = nullptr;
  if (!piece.file) return nothing;
  nothing.object.name = std::filesystem::path(file.path).stem().string();
  nothing.file = std::make_shared<const VdbFile>(file.path);
  nothing.grid = LoadedObject::kNoGrid;
  for (size_t i = 0; i < nothing.file->entries().size(); ++i)
    if (nothing.grid == LoadedObject::kNoGrid && plainName(nothing.file->entries()[i]) == piece.gridName)
      nothing.grid = i;
  return nothing;
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
  for (const LoadedObject& object : objects)
    if (!object.labels) return;
  const std::vector<std::int64_t> shared = sharedLabels(objects);
  for (LoadedObject& object : objects) {
    const std::vector<std::int64_t> own = labelsOf(*object.image);
    object.object.inner.assign(shared.size(), nullptr);
    const double voxelSize = object.object.levelSet->voxelSize()[0];
    tbb::parallel_for(size_t(0), shared.size(), [&](size_t n) {
      if (!std::binary_search(own.begin(), own.end(), shared[n])) return;
      try {
        object.object.inner[n] = levelSetOf(shapeOfLabel(*object.image, shared[n]), 0.5, voxelSize);
      } catch (const GeometryError&) {  // too thin for the voxel size: it moves with its surroundings
      }
    });
  }
}

}  // namespace slicemorph

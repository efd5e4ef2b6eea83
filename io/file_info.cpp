#include "slicemorph/io/file_info.h"

#include "engine/volume/image_shape.h"
#include "engine/volume/level_set.h"
#include "io/contours/contour_info.h"
#include "io/format.h"
#include "io/image/image_formats.h"
#include "io/image/label_values.h"
#include "io/mesh/mesh_reader.h"
#include "io/paths.h"
#include "io/vdb/grid_choice.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_slices.h"
#include "slicemorph/io/placing.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <sstream>
#include <tuple>
#include <utility>

namespace slicemorph {
namespace {

MeshInfo describeMesh(const InputSpec& input, const Placing& placing) {
  StoredMesh stored = readPolygons(input);
  place(stored.mesh.points, {placing.scale, placing.rotation});
  const MeshTopology found = inspectMesh(stored.mesh);
  MeshInfo info;
  info.points = stored.points;
  info.faces = stored.faces;
  info.colors = stored.colorsOf;
  info.shells = found.shells;
  info.boundaryEdges = found.boundaryEdges;
  info.boundaryLoops = found.boundaryLoops;
  info.nonManifoldEdges = found.nonManifoldEdges;
  info.closed = found.shells > 0 && found.boundaryEdges == 0 && found.nonManifoldEdges == 0;
  info.signedVolume = found.signedVolume;
  openvdb::BBoxd box;
  for (const std::uint32_t corner : stored.mesh.corners) box.expand(Vec3d(stored.mesh.points[corner]));
  if (!stored.mesh.corners.empty()) {
    const Vec3d origin = placing(stored.origin);
    info.boxMin = box.min() + origin;
    info.boxMax = box.max() + origin;
  }
  try {
    info.notes = checkSolid(input.path, stored, {});
  } catch (const Error& error) {
    info.problem = error.what();
  }
  return info;
}

bool isRotated(const openvdb::math::Transform& transform) {
  if (!transform.isLinear()) return true;
  const auto matrix = transform.baseMap()->getAffineMap()->getMat4();
  const double size = transform.voxelSize().length();
  for (int i = 0; i < 3; ++i) {
    if (matrix(i, i) <= 0) return true;
    for (int j = 0; j < 3; ++j) {
      if (i != j && std::abs(matrix(i, j)) > 1e-6 * size) return true;
    }
  }
  return false;
}

/// Sets the number of active voxels from the statistics that the file keeps with a grid, without reading
/// voxels. Returns their box, which is empty where it is not known.
openvdb::CoordBBox describeStatistics(const openvdb::GridBase& grid, GridInfo& info) {
  const auto count = grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
  const auto low = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto high = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  info.activeVoxels = count ? std::uint64_t(count->value()) : 0;
  if (info.activeVoxels == 0 || !low || !high) return {};
  return {openvdb::Coord(low->value()), openvdb::Coord(high->value())};
}

void describeTransform(const openvdb::GridBase& grid, const openvdb::CoordBBox& voxels, GridInfo& info) {
  info.voxelSize = grid.voxelSize();
  const auto [low, high] = std::minmax({info.voxelSize.x(), info.voxelSize.y(), info.voxelSize.z()});
  info.uniform = high - low <= 1e-6 * high;
  info.rotated = isRotated(grid.transform());
  if (voxels.empty()) return;
  const openvdb::BBoxd box = grid.transform().indexToWorld(voxels);
  info.boxMin = box.min();
  info.boxMax = box.max();
}

void describeScalars(const FloatGrid& grid, GridInfo& info) {
  const LevelSetReading reading = readingOf(grid);
  info.scalar = true;
  info.background = grid.background();
  info.minimum = reading.minimum;
  info.maximum = reading.maximum;
  info.problem = reading.problem;
  if (!reading.problem.empty()) return;
  std::ostringstream how;
  how << (reading.fog ? "fog volume" : "level set");
  if (reading.rebuilt.empty()) {
    how << ", as it is";
  } else {
    how << ", rebuilt from its surface at " << reading.iso << ": " << reading.rebuilt;
  }
  info.reading = how.str();
}

GridInfo describeGrid(const VdbFile& file, size_t index, const Placing& placing) {
  GridInfo info;
  info.name = file.entries()[index].name;
  info.type = file.entries()[index].type;
  info.halfFloat = file.entries()[index].halfFloat;
  try {
    const openvdb::GridBase::Ptr header = placed(file.readHeader(index), placing);
    if (!header) throw IoError("of a type that this OpenVDB does not know");
    info.type = header->valueType();
    info.gridClass = openvdb::GridBase::gridClassToString(header->getGridClass());
    if (!isScalar(*header)) {
      info.problem = "holds " + info.type + " values, no scalar ones that have a surface";
      describeTransform(*header, describeStatistics(*header, info), info);
      return info;
    }
    const FloatGrid::ConstPtr grid = asFloatGrid(placed(file.read(index), placing));
    info.activeVoxels = grid->activeVoxelCount();
    describeTransform(*grid, grid->evalActiveVoxelBoundingBox(), info);
    describeScalars(*grid, info);
  } catch (const std::exception& error) {
    info.problem = error.what();
  }
  return info;
}

/// Sets the grid that loadObject would take, where it would find one.
void chooseGridOf(const VdbFile& file, const std::string& path, VdbInfo& info) {
  try {
    const std::vector<GridCandidate> candidates = gridCandidates(file, path);
    for (const GridCandidate& candidate : candidates) {
      if (candidate.isStatic && !candidates[0].isStatic) return;
      if (!info.grids[candidate.index].problem.empty()) continue;
      info.chosen = info.grids[candidate.index].name;
      if (candidates.size() > 1) info.why = candidate.why;
      return;
    }
  } catch (const InputError&) {
  }
}

VdbInfo describeVdb(const InputSpec& input, const Placing& placing) {
  const VdbFile file(input.path);
  VdbInfo info;
  info.fileVersion = file.fileVersion();
  info.libraryVersion = file.libraryVersion();
  if (!input.selection.empty()) {
    info.grids.push_back(describeGrid(file, findGrid(file, input), placing));
    if (info.grids[0].problem.empty()) info.chosen = info.grids[0].name;
    return info;
  }
  for (size_t i = 0; i < file.entries().size(); ++i) info.grids.push_back(describeGrid(file, i, placing));
  chooseGridOf(file, input.path, info);
  return info;
}

/// The least and the largest finite value; 0 where there is none.
template <typename T>
std::pair<double, double> finiteRange(const std::vector<T>& values) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const T value : values) {
    const double v = double(value);
    if (!std::isfinite(v)) continue;
    low = std::min(low, v), high = std::max(high, v);
  }
  return low <= high ? std::pair(low, high) : std::pair(0.0, 0.0);
}

bool hasNote(const ImageFile& file, const char* code) {
  return std::any_of(file.notes.begin(), file.notes.end(),
                     [&](const Note& note) { return note.code == code; });
}

ImageInfo describeImage(const ImageFile& file) {
  constexpr const char* kTypes[] = {"uint8", "int16", "uint16", "int32", "float", "double"};
  const ImageLattice& lattice = file.image.lattice;
  ImageInfo info;
  info.name = file.name, info.format = file.format, info.about = file.about, info.notes = file.notes;
  info.volumes = file.volumes;
  info.type = kTypes[file.image.values.index()];
  info.size = lattice.size, info.spacing = lattice.spacing(), info.origin = lattice.origin;
  for (int d = 0; d < 3; ++d) info.axes[d] = lattice.step[d].unit();
  const bool any = std::visit(
      [&](const auto& values) {
        if (values.empty()) return false;
        std::tie(info.minimum, info.maximum) = finiteRange(values);
        return true;
      },
      file.image.values);
  if (!any) {
    const bool refused = hasNote(file, kImageRefused);
    info.looked = info.placed = false;
    if (refused) info.type.clear();
    info.reading = refused ? "refused" : "cannot be read without --spacing X,Y,Z";
  } else if (isStatedLabels(file) || looksLikeLabels(file.image)) {
    info.labels = labelsOf(file.image).size();
    info.reading = "map of " + std::to_string(info.labels) + (info.labels == 1 ? " label" : " labels") +
                   ", the shape is that of all";
  } else if (info.minimum < info.maximum) {
    std::ostringstream how;
    how << "grey values, the shape is what is above " << otsuValue(file.image) << " (--iso sets another)";
    info.reading = how.str();
  } else {
    info.reading = "all values are equal: no shape";
  }
  return info;
}

/// Images of more voxels are described by their headers where these alone can be read: of 400^3, which takes a second.
constexpr double kMostToRead = 64e6;

/// Says that an image was described by its header.
void tellHeaderOnly(ImageInfo& info) {
  std::ostringstream text;
  text << "not looked at: of more than " << kMostToRead / 1e6 << " million voxels only the header is read";
  info.looked = false, info.placed = true, info.reading = text.str();
}

/// The images of an input, without the values of large ones.
std::vector<ImageInfo> describeImages(const InputSpec& input, const ImageOptions& options) {
  std::vector<ImageInfo> infos;
  const auto isLarge = [](const ImageFile& file) { return double(file.image.lattice.count()) > kMostToRead; };
  if (std::optional<ImageSlices> slices = openImageSlices(input, options); slices && isLarge(slices->file)) {
    slices->file.name = input.text;
    infos.push_back(describeImage(slices->file));
    tellHeaderOnly(infos.back());
    return infos;
  }
  visitImages(input, options, kMostToRead, [&](ImageFile file) {
    const bool read = std::visit([](const auto& values) { return !values.empty(); }, file.image.values);
    if (read) takeLabels(file.image, /*asked=*/false, file.notes);
    infos.push_back(describeImage(file));
    if (hasNote(file, kHeaderOnly)) tellHeaderOnly(infos.back());
  });
  return infos;
}

}  // namespace

FileInfo describeFile(const InputSpec& given, const ImageOptions& options) {
  initialiseVdb();
  const InputSpec input = stillInput(given);
  const Placing placing = placingOf(input.placing, options.up);
  FileInfo info;
  info.contents = input.contents;
  info.path = input.path;
  if (input.isImage()) {
    for (const std::string& file : filesOfInput(input)) info.bytes += std::filesystem::file_size(file);
    info.images = describeImages(input, options);
    info.format = info.images[0].format;
    return info;
  }
  info.bytes = sizeOfInput(input.path);
  if (input.contents == Contents::kContours) {
    ContourFile file = readContours(input);
    info.structures = describeStructures(file.sets);
    info.notes = std::move(file.notes), info.format = input.format->name;
    for (const RefusedSet& set : file.refused)
      info.notes.emplace_back("contours.refused", Severity::kWarning, "", set.why);
    return info;
  }
  if (input.contents != Contents::kMesh && input.contents != Contents::kGrids) refuseAsShape(input);
  info.format = input.format->name;
  if (input.isGrids())
    info.vdb = describeVdb(input, placing);
  else
    info.mesh = describeMesh(input, placing);
  return info;
}

}  // namespace slicemorph

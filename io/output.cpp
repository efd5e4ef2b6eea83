#include "slicemorph/io/output.h"

#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "io/format.h"
#include "io/mesh/far_origin.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/io/vdb_writer.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace slicemorph {

OutputName::OutputName(std::string pattern) : pattern_(std::move(pattern)) {
  // The last run of # in the file's name; a # in a folder's name means nothing.
  const size_t last = pattern_.rfind('#'), slash = pattern_.rfind('/');
  if (last == std::string::npos || (slash != std::string::npos && last < slash)) return;
  const size_t before = pattern_.find_last_not_of('#', last);
  first_ = before == std::string::npos ? 0 : before + 1;
  hashes_ = last + 1 - first_;
}

std::string OutputName::path(int frame) const {
  if (!isSequence()) return pattern_;
  std::string digits = std::to_string(frame < 0 ? -std::int64_t(frame) : std::int64_t(frame));
  if (digits.size() < hashes_) digits.insert(0, hashes_ - digits.size(), '0');
  if (frame < 0) digits.insert(0, 1, '-');
  return std::string(pattern_).replace(first_, hashes_, digits);
}

std::string OutputName::extension() const { return extensionOf(pattern_); }

void checkSurfaceOutput(const std::string& path) {
  const Format* format = formatToWrite(path);
  if (format && format->writeStructures)
    throw InputError(path, "holds structures, which `slicemorph convert` and `slicemorph reconstruct` write");
  if (!format || (format->contents != Contents::kGrids && format->contents != Contents::kMesh)) {
    const std::string extension = extensionOf(path);
    throw InputError(
        path, "cannot write " +
                  (extension.empty() ? "a file without an extension" : "the extension '" + extension + "'") +
                  "; use " + writableList(Contents::kGrids, ", ") + ", " +
                  writableList(Contents::kMesh, ", ") + ", or " + writableList(Contents::kImage, ", ") +
                  " for images, " + structureList(", ") + " for structures");
  }
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  std::error_code ignored;
  if (!std::filesystem::exists(folder, ignored))
    throw IoError(path, "the folder " + folder.string() + " does not exist");
  if (!std::filesystem::is_directory(folder, ignored)) throw IoError(path, folder.string() + " is no folder");
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw IoError(path, "the folder " + folder.string() + " cannot be written to: " + std::strerror(errno));
  if (std::filesystem::is_directory(path, ignored)) throw IoError(path, "is a folder, not a file");
}

openvdb::GridBase::Ptr surfaceGrid(const FloatGrid& levelSet, const SurfaceOutput& options) {
  const FloatGrid::Ptr floats =
      FloatGrid::create(openvdb::ConstPtrCast<openvdb::FloatTree>(levelSet.treePtr()));
  floats->insertMeta(levelSet);
  floats->setTransform(levelSet.transform().copy());
  const openvdb::GridBase::Ptr grid =
      options.doubles ? openvdb::GridBase::Ptr(new openvdb::DoubleGrid(*floats)) : floats;
  grid->setName(options.name);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setSaveFloatAsHalf(options.halfFloat);
  grid->insertMeta("fps", openvdb::FloatMetadata(float(options.vdb.framesPerSecond)));
  grid->insertMeta("frame", openvdb::Int32Metadata(options.vdb.frame));
  return grid;
}

Mesh meshForFile(const FloatGrid& levelSet, const openvdb::Vec3SGrid* colors) {
  openvdb::BBoxd box;
  if (const openvdb::CoordBBox voxels = levelSet.evalActiveVoxelBoundingBox(); !voxels.empty())
    box = levelSet.transform().indexToWorld(voxels);
  const Vec3d origin = farOrigin(box, levelSet.voxelSize()[0]);
  const auto moved = [&](const auto& grid) {  // the same voxels elsewhere
    const auto transform = grid.transform().copy();
    if (origin != Vec3d(0.0)) transform->postTranslate(-origin);
    return grid.copyReplacingTransform(transform);
  };
  Mesh mesh = surfaceOf(*moved(levelSet));
  if (colors) mesh.colors = colorsAt(*moved(*colors), mesh.points);
  mesh.origin = origin;
  return mesh;
}

bool isGridOutput(const std::string& path) {
  const Format* format = formatToWrite(path);
  return format && format->writeGrids;
}

void writeGridFile(const std::string& path, const openvdb::GridCPtrVec& grids, const VdbOutput& options) {
  formatToWrite(path)->writeGrids(path, grids, options);
}

void writeSurface(const std::string& path, const FloatGrid& levelSet, const SurfaceOutput& options) {
  checkSurfaceOutput(path);
  if (formatToWrite(path)->contents == Contents::kGrids) {
    openvdb::GridCPtrVec grids{surfaceGrid(levelSet, options)};
    if (options.colors) grids.push_back(options.colors);
    writeGridFile(path, grids, options.vdb);
  } else {
    writeMesh(path, meshForFile(levelSet, options.colors.get()), options.space);
  }
}

}  // namespace slicemorph

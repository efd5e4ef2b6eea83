#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/mesh.h"

#include <openvdb/io/Compression.h>

#include <cstdint>
#include <string>

namespace slicemorph {

/// An output name of the command line: `name.####.vdb` is a sequence (the run of # is the frame number,
/// padded with zeros), any other name a single file.
class OutputName {
 public:
  explicit OutputName(std::string pattern);
  bool isSequence() const { return hashes_ > 0; }
  std::string path(int frame) const;
  std::string extension() const;  ///< lower case, with the dot

 private:
  std::string pattern_;
  size_t first_ = 0, hashes_ = 0;
};

/// Metadata and compression of a VDB file.
struct VdbOutput {
  double framesPerSecond = 24;
  int frame = 1;
  openvdb::MetaMap metadata;  ///< of the file, in addition to ours
  std::uint32_t compression =
      openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK;  ///< flags of openvdb::io
};

struct SurfaceOutput {
  std::string name = "surface";  ///< of the grid
  bool halfFloat = false;
  bool doubles = false;  ///< the grid holds doubles
  VdbOutput vdb;
  openvdb::Vec3SGrid::ConstPtr colors = nullptr;  ///< around the surface, named "Cd"; null: none
  MeshSpace space = MeshSpace::kUnsaid;           ///< of meshes
};

/// Throws InputError where `path` has no extension that writeSurface knows, IoError where its folder does not
/// exist or cannot be written to: to be called before any work is done.
void checkSurfaceOutput(const std::string& path);

/// The level set as a grid of an output; of floats it shares its tree.
openvdb::GridBase::Ptr surfaceGrid(const FloatGrid& levelSet, const SurfaceOutput& options = {});

/// The surface of a level set with its colours (null: none), as a mesh to be written. What lies far from 0, as on maps,
/// has its origin taken out of the points, which keep their digits so.
Mesh meshForFile(const FloatGrid& levelSet, const openvdb::Vec3SGrid* colors);

/// Writes a level set by extension: `.vdb .nvdb` as a grid, followed by its colours; `.obj .ply
/// .stl .glb` as its surface mesh, whose points get the colours at them (STL: none). The file appears whole
/// or not at all (see AtomicFile). Throws as checkSurfaceOutput does, and IoError.
void writeSurface(const std::string& path, const FloatGrid& levelSet, const SurfaceOutput& options = {});

}  // namespace slicemorph

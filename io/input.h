#pragma once

#include "engine/slicemorph.h"
#include "io/vdb_reader.h"

#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

struct LoadOptions {
  double voxelSize = 0;  ///< world units; 0: `resolution` for meshes, their own for VDBs
  int resolution = 0;    ///< voxels along the longest side, 8 to 4096; 0: 256 for meshes, their own for VDBs
  double iso = 0;        ///< the surface's value in a VDB grid; 0: found from the density in fog
  int fogResolution = 0; ///< most voxels along the longest side of the shape found in fog; 0: as many as the fog has
};

struct LoadedObject {
  Object object;
  bool halfFloat = false;           ///< the input grid was stored as half floats
  std::vector<std::string> notes;   ///< what was repaired, chosen or converted, one sentence each
  bool fog = false;                 ///< the shape is that of a fog volume
  std::shared_ptr<const VdbFile> file;  ///< null for meshes
  size_t grid = 0;                  ///< in the file, that the shape is taken from
  bool named = false;               ///< that grid was asked for by name
};

/// Reads one input of the command line as a level set: `file.vdb`, `file.vdb:grid`, `.obj .ply .stl .off .glb`.
/// Throws IoError (missing, unreadable, truncated, not of its format), InputError (extension, grid name, voxel size),
/// GeometryError (open, not orientable, empty). Every message names the file.
LoadedObject loadObject(const std::string& input, const LoadOptions& options = {});

}  // namespace slicemorph

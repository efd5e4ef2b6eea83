#pragma once

#include "engine/slicemorph.h"

#include <string>
#include <vector>

namespace slicemorph {

struct LoadOptions {
  double voxelSize = 0;  ///< world units; 0: `resolution` for meshes, their own for VDBs
  int resolution = 0;    ///< voxels along the longest side, 8 to 4096; 0: 256 for meshes, their own for VDBs
  double iso = 0;        ///< the surface's value in a VDB grid
};

struct LoadedObject {
  Object object;
  bool halfFloat = false;           ///< the input grid was stored as half floats
  std::vector<std::string> notes;   ///< what was repaired, chosen or converted, one sentence each
};

/// Reads one input of the command line as a level set: `file.vdb`, `file.vdb:grid`, `.obj .ply .stl .off .glb`.
/// Throws IoError (missing, unreadable, truncated, not of its format), InputError (extension, grid name, voxel size),
/// GeometryError (open, not orientable, empty). Every message names the file.
LoadedObject loadObject(const std::string& input, const LoadOptions& options = {});

}  // namespace slicemorph

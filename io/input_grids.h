#pragma once

#include "io/exr/exr_slice.h"
#include "slicemorph/io/input.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// What an input holds, grid by grid.
struct InputGrids {
  std::vector<SliceGrid> grids;  ///< with voxels, in the file's order; a surface that was asked for last
  FloatGrid::ConstPtr shape;     ///< its shape as a level set; null where none was needed
  std::string units;             ///< "mm" of images, else "world units"
  openvdb::MetaMap metadata;     ///< of a VDB file
  Notes notes;                   ///< what was chosen, converted, left out, one sentence each
};

/// Reads any input of the command line as grids: all of a VDB's as they are (`file.vdb:grid` that one alone),
/// a mesh's `surface`, an image's `image` or `labels`. With an iso value the `surface` at it comes too.
/// `wanted`: only these; empty: all. `needsShape`: fill `shape` whatever is wanted. The files must not change
/// while the grids live. Throws as loadObject does; InputError for an unknown grid, listing what is there.
InputGrids readInputGrids(const InputSpec& input, const std::vector<std::string>& wanted,
                          const LoadOptions& options, bool needsShape = false);

}  // namespace slicemorph

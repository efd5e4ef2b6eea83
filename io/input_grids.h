#pragma once

#include "io/exr/exr_slice.h"
#include "io/held_input.h"
#include "slicemorph/io/input.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// An input as grids.
struct InputGrids {
  std::vector<SliceGrid> grids;  ///< not empty ones, in the file's order; then the surface, if wanted
  FloatGrid::ConstPtr shape;     ///< its shape as a level set; null where none was needed
  std::string units;             ///< "mm" of images, else "world units"
  openvdb::MetaMap metadata;     ///< of a VDB file
  Notes notes;                   ///< what was chosen, converted or left out, one sentence each
};

/// Reads any input of the command line as grids: those of a VDB unchanged (of `file.vdb:grid` that one
/// alone), a mesh as `surface`, an image as `image` or `labels`. With an iso value also the `surface` at it.
/// `wanted`: only these grids; empty: all. `needsShape`: always fill `shape`. The files must not change while
/// the grids live. Throws as loadObject does; InputError for an unknown grid, listing those of the input.
InputGrids readInputGrids(const InputSpec& input, const std::vector<std::string>& wanted,
                          const LoadOptions& options, bool needsShape = false);
/// The same of an input in memory.
InputGrids readInputGrids(const HeldInput& input, const std::vector<std::string>& wanted,
                          const LoadOptions& options, bool needsShape = false);

}  // namespace slicemorph

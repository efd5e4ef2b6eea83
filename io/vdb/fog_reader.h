#pragma once

#include "engine/render/render_fog.h"
#include "slicemorph/io/input_spec.h"
#include "slicemorph/io/vdb_reader.h"

#include <optional>
#include <string>

namespace slicemorph {

/// Reads what the renderer needs of a fog input (`file.vdb`, `file.vdb:grid`): the density, which is the grid
/// named or the first that loadObject tries; the first of `flame`, `flames`, `fire`, `heat` and `temperature`
/// that the file has as a scalar grid (an empty one means that nothing burns); and `color` or `Cd`. None for
/// inputs that are not fog. Throws IoError and InputError as loadObject does, and GeometryError for a density
/// with values that are not finite.
std::optional<Fog> readFog(const InputSpec& input);
/// The same of a file that is open.
std::optional<Fog> readFog(const VdbFile& file, const InputSpec& input);

/// The same from grids in memory, of which `density` is the density.
Fog fogOf(const openvdb::GridBase::ConstPtr& density, const openvdb::GridCPtrVec& grids);

/// Whether a grid of this name is drawn with the density.
bool isDrawn(const std::string& name);

}  // namespace slicemorph

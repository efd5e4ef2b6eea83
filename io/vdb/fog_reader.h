#pragma once

#include "engine/render/render_fog.h"
#include "slicemorph/io/input_spec.h"

#include <optional>
#include <string>

namespace slicemorph {

/// What a renderer needs of an input that is fog (`file.vdb`, `file.vdb:grid`): the density, which is the
/// grid named or the one that loadObject takes; with it the first of `flame`, `flames`, `fire`, `heat` and
/// `temperature` that the file has as a scalar grid (an empty flame says that nothing burns), and `color` or
/// `Cd`. None for inputs that are no fog, and for files without density whose other grids may be shapes.
/// Throws IoError and InputError as loadObject, and InputError for a density with values that are not finite.
std::optional<Fog> readFog(const InputSpec& input);

/// The same of grids in memory, whose density is known.
Fog fogOf(const openvdb::GridBase::ConstPtr& density, const openvdb::GridCPtrVec& grids);

/// Whether a grid of this name is drawn beside the density.
bool isDrawn(const std::string& name);

}  // namespace slicemorph

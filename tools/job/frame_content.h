#pragma once

#include "io/vdb/grid_sets.h"
#include "slicemorph/note.h"
#include "tools/job/morph_settings.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// What the frames of a job hold: the surface, or the fog that the shapes are part of, and all that rides
/// along.
struct FrameContent {
  bool surface = true;             ///< as a grid of the output, a mesh or a picture
  bool images = false;             ///< all inputs are images, and the result shows their values
  std::vector<GridSet> sets;       ///< grids that ride along, and the shapes' own where these are fog
  std::optional<size_t> shapeSet;  ///< of `sets`: the fog that the shapes are part of; none: no fog
  std::string colorName;           ///< of the grid of the surface's colours; empty: no input has any
  Notes notes;                     ///< what is left out and why
};

/// Chooses by output, method and --grids. `first`: these are the inputs of the first frame, in which all that
/// is asked for must be there; in others of a sequence grids may come and go. Throws InputError.
FrameContent contentOf(const MorphSettings& settings, const std::vector<LoadedObject>& inputs, bool first);

}  // namespace slicemorph

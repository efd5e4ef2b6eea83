#pragma once

#include "io/vdb/grid_sets.h"
#include "slicemorph/note.h"
#include "tools/job/morph_settings.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// What the frames of a job hold: the surface, or the fog that the shapes were found in, and the other grids.
struct FrameContent {
  bool surface = true;                  ///< as a grid of the output, a mesh or a picture
  std::string surfaceName = "surface";  ///< of its grid
  bool images = false;                  ///< all inputs are images, and the result shows their values
  bool labelFigures = false;            ///< a report tells of the inputs' labels
  std::vector<GridSet> sets;            ///< the other grids, and the shapes' own where these are fog
  std::optional<size_t> shapeSet;       ///< index in `sets` of the shapes' fog; none: no fog
  std::string colorName;  ///< name of the grid of the surface's colours; empty: no input has any
  Notes notes;            ///< what is left out and why
};

/// Chooses by output, method and --grids. `first`: these are the inputs of the first frame, which must have
/// all grids that are asked for; in later frames of a sequence grids may be missing. Throws InputError.
FrameContent contentOf(const MorphSettings& settings, const std::vector<LoadedObject>& inputs, bool first);

}  // namespace slicemorph

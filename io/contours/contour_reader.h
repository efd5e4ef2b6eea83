#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/io/input_spec.h"
#include "slicemorph/note.h"

namespace slicemorph {

struct ContourFile {
  std::vector<ContourSet> sets;  ///< in the file's order; in a CSL file every set has all planes of the file
  Notes notes;                   ///< what was left out or repaired, one sentence each
};

/// Reads a `.csl` file, or else a DICOM RT structure set. World: the file's own coordinates (DICOM: the
/// patient's, LPS millimetres). Throws IoError naming the file (and region and plane): missing, cut short,
/// damaged, not of that kind, points off their plane, without a single closed contour.
ContourFile readContours(const InputSpec& input);
ContourFile readContours(const std::string& text);

}  // namespace slicemorph

#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/io/input_spec.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// An object whose contours cannot be used.
struct RefusedSet {
  int label = 0;
  std::string name, why;
};

struct ContourFile {
  std::vector<ContourSet> sets;  ///< of DICOM in the file's order; of CSL by
                                 ///< label, each with all planes
  std::vector<RefusedSet> refused;
  Notes notes;  ///< what was left out or repaired, one sentence each
};

/// Reads a `.csl` file, or else a DICOM RT structure set. World space is the file's own coordinates (DICOM:
/// the patient's, LPS millimetres). Throws IoError, naming the file (and region or plane), where it is
/// missing, cut short, damaged or of another kind, has points off their plane or no closed contour.
ContourFile readContours(const InputSpec& input);
ContourFile readContours(const std::string& text);

}  // namespace slicemorph

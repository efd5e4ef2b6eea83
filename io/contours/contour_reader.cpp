#include "io/contours/contour_reader.h"

#include "io/contours/rtstruct_reader.h"
#include "io/format.h"

namespace slicemorph {

ContourFile readContours(const InputSpec& input) {
  // What no format recognises may be a damaged structure set: the DICOM reader's error is the most helpful.
  const bool known = input.format && input.format->readContours;
  return known ? input.format->readContours(input.path) : readRtStructureSet(input.path);
}

ContourFile readContours(const std::string& text) { return readContours(parseInput(text)); }

}  // namespace slicemorph

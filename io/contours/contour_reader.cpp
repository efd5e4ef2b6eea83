#include "io/contours/contour_reader.h"

#include "io/contours/rtstruct_reader.h"
#include "io/format.h"

namespace slicemorph {

ContourFile readContours(const InputSpec& input) {
  // A structure set that is too damaged to be known is told so by its own reader.
  const bool known = input.format && input.format->readContours;
  return known ? input.format->readContours(input.path) : readRtStructureSet(input.path);
}

ContourFile readContours(const std::string& text) { return readContours(parseInput(text)); }

}  // namespace slicemorph

#pragma once

#include "slicemorph/io/input.h"
#include "tools/job/job_events.h"
#include "tools/job/picture_options.h"

#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph render` is to do; values are checked.
struct RenderJob {
  std::vector<std::string> inputs;
  std::string output;           ///< pictures, a file each, or a video; empty: none
  std::string sheet;            ///< contact sheet of all pictures; empty: none
  int columns = 0;              ///< of the sheet; 0: about as wide as high
  int turntable = 0;            ///< pictures of a full turn, during which a sequence plays once; 0: no turn
  double framesPerSecond = 24;  ///< of a video
  bool asSurface = false;       ///< fog is drawn as the shape in it
  PictureOptions picture;
  LoadOptions load;
};

/// Renders shapes, fog and sequences with one camera. Throws InputError, IoError, GeometryError, Cancelled.
void renderPictures(const RenderJob& job, JobEvents& events);

}  // namespace slicemorph

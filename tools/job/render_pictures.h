#pragma once

#include "slicemorph/io/input.h"
#include "tools/job/job_events.h"
#include "tools/job/picture_options.h"

#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph render` is to do, checked.
struct RenderJob {
  std::vector<std::string> inputs;
  std::string output;           ///< pictures, a file each, or one that moves; empty: none
  std::string sheet;            ///< all pictures on one; empty: none
  int columns = 0;              ///< of the sheet; 0: about as wide as high
  int turntable = 0;            ///< pictures of a full turn, during which a sequence plays once; 0: no turn
  double framesPerSecond = 24;  ///< of a file that moves
  bool asSurface = false;       ///< fog is drawn as the shape in it
  PictureOptions picture;
  LoadOptions load;
};

/// Pictures of shapes, fog and sequences, seen by one camera. Throws InputError, IoError, GeometryError,
/// Cancelled.
void renderPictures(const RenderJob& job, JobEvents& events);

}  // namespace slicemorph

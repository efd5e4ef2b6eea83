#pragma once

#include "engine/render/picture.h"
#include "tools/job/job_events.h"
#include "tools/job/option_set.h"

#include <functional>
#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph render` is to do; values are checked.
struct RenderJob {
  std::vector<std::string> inputs;
  HeldInputs held;              ///< those of the inputs that are in memory
  std::string output;           ///< pictures, a file each, or a video; empty: none
  std::string sheet;            ///< contact sheet of all pictures; empty: none
  int columns = 0;              ///< of the sheet; 0: about as wide as high
  int turntable = 0;            ///< pictures of a full turn, during which a sequence plays once; 0: no turn
  double framesPerSecond = 24;  ///< of a video
  bool asSurface = false;       ///< fog is drawn as the shape in it
  PictureOptions picture;
  LoadOptions load;
  /// Is given every picture, beside what is written, and its number; empty: nothing is.
  std::function<void(const Picture&, int)> take;
};

/// Checks the options of `render`, but not whether inputs are there and outputs can be written. Throws InputError.
RenderJob renderJob(const OptionSet& options);

/// Checks that the outputs that are named can be written. Throws InputError, and IoError where a folder is missing.
void checkRenderOutputs(const RenderJob& job);

/// Renders shapes, fog and sequences with one camera. Throws InputError, IoError, GeometryError, Cancelled.
void renderPictures(const RenderJob& job, JobEvents& events);

}  // namespace slicemorph

#pragma once

#include "engine/render/render_fog.h"
#include "engine/sections/place_sections.h"
#include "slicemorph/note.h"
#include "tools/job/frame_maker.h"

#include <vector>

namespace slicemorph {

/// How a morph's frames are put straight into images, EXR slices of their grids or pictures of them: one
/// camera, one look and one stack of planes serve all frames.
struct ImageSetup {
  Camera camera;
  FogLook look;
  std::vector<SectionPlane> planes;  ///< none where each frame has its own, across its spine
  Notes notes;
};

/// Looks where the shapes will be in all frames and chooses camera, look or planes, once the maker has been
/// moved to the first frame. Reads the files of sequences for that.
ImageSetup setUpImages(const MorphSettings& settings, const FrameMaker& maker, Progress& progress);

/// Writes the image of one frame and returns what was found. Throws IoError; InputError for planes that do
/// not cut the shapes.
Notes writeFrameImage(const FrameTask& task, const ImageSetup& setup, const MorphFrame& frame,
                      const Progress& cancel);

}  // namespace slicemorph

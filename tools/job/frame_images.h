#pragma once

#include "engine/render/render_fog.h"
#include "engine/sections/place_sections.h"
#include "slicemorph/note.h"
#include "tools/job/frame_maker.h"

#include <vector>

namespace slicemorph {

/// How a morph's frames become images, EXR slices of their grids or pictures: one camera, one look or one
/// stack of planes for all frames.
struct ImageSetup {
  Camera camera;
  FogLook look;
  std::vector<SectionPlane> planes;  ///< none where each frame has its own, across its spine
  Notes notes;
};

/// Surveys all frames and chooses camera and look, or planes. The maker must have been moved to the first
/// frame. Reads the files of sequences. Throws as surveyFrames.
ImageSetup setUpImages(const MorphSettings& settings, const FrameMaker& maker, Progress& progress);

/// Writes the image of one frame. Throws IoError; InputError for planes that do not cut the shapes.
Notes writeFrameImage(const FrameTask& task, const ImageSetup& setup, const MorphFrame& frame,
                      const Progress& cancel);

}  // namespace slicemorph

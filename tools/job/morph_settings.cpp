#include "tools/job/morph_settings.h"

#include <algorithm>

namespace slicemorph {

bool MorphSettings::moving() const { return std::any_of(inputs.begin(), inputs.end(), isMovingInput); }

bool MorphSettings::toFrameImages() const {
  const std::string extension = OutputName(output).extension();
  return extension == ".exr" || extension == ".png";
}

bool MorphSettings::oneGlb() const {
  const OutputName name(output);
  return name.extension() == ".glb" && !name.isSequence();
}

}  // namespace slicemorph

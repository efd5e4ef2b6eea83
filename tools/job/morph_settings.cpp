#include "tools/job/morph_settings.h"

#include "io/paths.h"

#include <algorithm>
#include <iterator>

namespace slicemorph {
namespace {

bool isOneOf(const std::string& output, const char* extension) {
  const OutputName name(output);
  return name.extension() == extension && !name.isSequence();
}

}  // namespace

std::vector<FrameJob> MorphSettings::wantedFrames() const {
  std::vector<FrameJob> wanted;
  std::copy_if(frames.begin(), frames.end(), std::back_inserter(wanted),
               [](const FrameJob& frame) { return frame.wanted; });
  return wanted;
}

InputSpec MorphSettings::input(size_t k) const {
  const HeldInput* const inMemory = heldAt(held, k);
  return inMemory ? inMemory->spec : parseInput(inputs[k]);
}

bool MorphSettings::allImages() const {
  for (size_t k = 0; k < inputs.size(); ++k)
    if (!input(k).isImage()) return false;
  return true;
}

bool MorphSettings::moving() const {
  for (size_t k = 0; k < inputs.size(); ++k)
    if (input(k).isMoving()) return true;
  return false;
}

bool MorphSettings::toFrameImages() const {
  const std::string extension = OutputName(output).extension();
  return extension == ".exr" || extension == ".png";
}

bool MorphSettings::oneGlb() const { return isOneOf(output, ".glb"); }

bool MorphSettings::oneUsda() const { return isOneOf(output, ".usda"); }

bool MorphSettings::oneImage() const {
  const std::string extension = fullExtensionOf(output);
  return (extension == ".nii" || extension == ".nii.gz") && !OutputName(output).isSequence() &&
         wantedFrames().size() > 1;
}

}  // namespace slicemorph

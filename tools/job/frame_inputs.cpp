#include "tools/job/frame_inputs.h"

#include "slicemorph/errors.h"

#include <algorithm>

namespace slicemorph {

FrameInputs::FrameInputs(const MorphSettings& settings)
    : settings_(settings), open_(settings.inputs.size()), loaded_(settings.inputs.size()) {
  for (const std::string& input : settings.inputs) {
    files_.emplace_back();
    const InputSpec spec = parseInput(input);
    if (spec.isMoving())
      for (InputFrame& frame : framesOf(spec)) files_.back().push_back(std::move(frame.input));
    else
      files_.back().push_back(spec);
  }
}

Notes FrameInputs::notes(size_t frames) const {
  Notes notes;
  for (size_t k = 0; k < files_.size(); ++k)
    if (isMovingInput(settings_.inputs[k]) && files_[k].size() < frames)
      notes.emplace_back("sequence.shorter", Severity::kNote, "",
                         settings_.inputs[k] + " has " + std::to_string(files_[k].size()) + " files for " +
                             std::to_string(frames) + " frames: the last one stays");
  return notes;
}

FrameInputs::Step FrameInputs::moveTo(size_t frame, Progress& progress) {
  Step step;
  for (size_t k = 0; k < files_.size(); ++k) {
    const InputSpec& file = files_[k][std::min(frame, files_[k].size() - 1)];
    if (open_[k] == file.text) continue;
    if (progress.cancelled()) throw Cancelled();
    progress.report("reading", double(k) / double(files_.size()));
    loaded_[k] = loadObject(file, optionsOfInput(settings_.load, k));
    open_[k] = file.text;
    step.changed = true;
    for (Note& note : about(file.text, loaded_[k].notes)) step.notes.push_back(std::move(note));
  }
  if (step.changed) addLabelSurfaces(loaded_);
  return step;
}

}  // namespace slicemorph

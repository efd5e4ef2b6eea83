#include "tools/job/frame_inputs.h"

#include "slicemorph/errors.h"
#include "tools/job/fit_inputs.h"

#include <algorithm>

namespace slicemorph {

FrameInputs::FrameInputs(const MorphSettings& settings, const std::string& grid)
    : settings_(settings),
      gridGiven_(!grid.empty()),
      placings_(settings.inputs.size()),
      open_(settings.inputs.size()),
      loaded_(settings.inputs.size()) {
  for (size_t k = 0; k < settings.inputs.size(); ++k) {
    InputSpec input = settings.input(k);
    if (gridGiven_) input.selection = grid;
    files_.emplace_back(input);
  }
}

LoadedObject FrameInputs::load(size_t input, size_t frame) {
  const HeldInput* const held = heldAt(settings_.held, input);
  LoadedObject loaded =
      held ? loadObject(*held, optionsFor(input)) : files_[input].load(frame, optionsFor(input));
  if (gridGiven_) loaded.named = false;
  return loaded;
}

Notes FrameInputs::notes(size_t frames) const {
  Notes notes;
  for (size_t k = 0; k < files_.size(); ++k) {
    for (Note& note : files_[k].notes()) notes.push_back(std::move(note));
    if (files_[k].moves() && files_[k].size() < frames)
      notes.emplace_back("sequence.shorter", Severity::kNote, "",
                         settings_.inputs[k] + " has " + std::to_string(files_[k].size()) + " files for " +
                             std::to_string(frames) + " frames: the last one stays");
  }
  return notes;
}

LoadOptions FrameInputs::optionsFor(size_t input) const {
  LoadOptions options = optionsOfInput(settings_.load, input);
  options.placing = placings_[input];
  for (size_t k = 0; k < files_.size(); ++k)
    if (k != input && !heldAt(settings_.held, k) && files_[k].file(0).isGrids() &&
        files_[input].file(0).isGrids() && files_[k].file(0).path != files_[input].file(0).path)
      options.besides.push_back(files_[k].file(0).path);
  return options;
}

Notes FrameInputs::fitted(size_t frame) {
  fitted_ = true;
  std::vector<openvdb::BBoxd> boxes;
  std::vector<FitKind> fits;
  for (size_t k = 0; k < loaded_.size(); ++k) {
    boxes.push_back(boxOfShape(*loaded_[k].object.levelSet));
    fits.push_back(fitOf(files_[k].file(frame).placing, settings_.options.fit));
  }
  placings_ = fittingPlacings(boxes, fits);
  for (size_t k = 0; k < loaded_.size(); ++k)
    if (!placings_[k].isIdentity()) loaded_[k] = load(k, frame);
  Notes notes = notesOnSizes(boxes, fits, settings_.inputs);
  for (size_t k = 0; k < loaded_.size(); ++k)
    if (!loaded_[k].placing.isIdentity())
      notes.push_back(noteOnPlacing(loaded_[k].placing, settings_.inputs[k]));
  return notes;
}

void FrameInputs::takeFrom(const FrameInputs& other) {
  for (size_t k = 0; k < other.open_.size(); ++k)
    if (!other.open_[k].empty() && !other.loaded_[k].nothing)
      known_.emplace(other.open_[k], other.loaded_[k]);
}

FrameInputs::Step FrameInputs::moveTo(size_t frame, Progress& progress) {
  Step step;
  for (size_t k = 0; k < files_.size(); ++k) {
    const InputSpec& file = files_[k].file(frame);
    if (open_[k] == file.text) continue;
    if (progress.cancelled()) throw Cancelled();
    progress.report("reading", double(k) / double(files_.size()));
    const auto known = known_.find(file.text);
    loaded_[k] = known == known_.end() ? load(k, frame) : known->second;
    open_[k] = file.text;
    step.changed = true;
    for (Note& note : about(file.text, loaded_[k].notes))
      (loaded_[k].nothing ? step.nothing : step.notes).push_back(std::move(note));
  }
  known_.clear();
  if (step.changed && !fitted_)
    for (Note& note : fitted(frame)) step.notes.push_back(std::move(note));
  if (step.changed) addLabelSurfaces(loaded_);
  return step;
}

}  // namespace slicemorph

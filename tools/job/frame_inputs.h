#pragma once

#include "slicemorph/io/input.h"
#include "slicemorph/note.h"
#include "tools/job/morph_settings.h"

#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// The inputs of a job at each of its frames: of a numbered sequence the file of that place in it, the last
/// one when it is over; any other input is the same throughout.
class FrameInputs {
 public:
  /// Throws IoError where there is no file of a sequence.
  explicit FrameInputs(const MorphSettings& settings);

  /// Which sequences end before a job of so many frames does, one sentence each.
  Notes notes(size_t frames) const;

  /// Loads what a frame (from 0) needs and is not loaded. Returns whether anything changed. Throws as
  /// loadObject.
  bool moveTo(size_t frame, Progress& progress);
  const std::vector<LoadedObject>& loaded() const { return loaded_; }
  /// Of the inputs loaded last, one sentence each.
  Notes takeNotes();

 private:
  const MorphSettings& settings_;
  std::vector<std::vector<InputSpec>> files_;  ///< per input
  std::vector<std::string> open_;              ///< per input: what is loaded
  std::vector<LoadedObject> loaded_;
  Notes notes_;
};

}  // namespace slicemorph

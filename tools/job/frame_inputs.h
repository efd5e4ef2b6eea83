#pragma once

#include "io/moving_input.h"
#include "slicemorph/note.h"
#include "tools/job/morph_settings.h"

#include <map>
#include <string>
#include <vector>

namespace slicemorph {

/// The inputs of a job at each of its frames: of a numbered sequence the n-th file, and its last one when it
/// is over; any other input is the same throughout.
class FrameInputs {
 public:
  /// `grid`: by which the files of all inputs are read, of which then none names one; empty: each input's own, see
  /// MovingInput. Throws IoError where there is no file of a sequence.
  explicit FrameInputs(const MorphSettings& settings, const std::string& grid = "");

  /// Notes on the sequences that have fewer files than the job has frames, or gaps.
  Notes notes(size_t frames) const;

  /// Spares reading the files that the inputs of another part of the same sequences, of the same settings and grid, have
  /// just loaded, at the next step.
  void takeFrom(const FrameInputs& other);

  /// What a step from one frame to another changed.
  struct Step {
    bool changed = false;
    Notes notes;    ///< of reading
    Notes nothing;  ///< on files that hold nothing
  };
  /// Loads the files that a frame (from 0) needs unless they are loaded. Throws as loadObject, and Cancelled.
  Step moveTo(size_t frame, Progress& progress);
  const std::vector<LoadedObject>& loaded() const { return loaded_; }

 private:
  const MorphSettings& settings_;
  LoadOptions optionsFor(size_t input) const;
  LoadedObject load(size_t input, size_t frame);
  /// Finds how the inputs of the first frame are to be placed, and loads those anew that are.
  Notes fitted(size_t frame);

  bool gridGiven_ = false;         ///< the grid is, though not by the inputs' names
  bool fitted_ = false;            ///< the placings are known
  std::vector<Placing> placings_;  ///< per input

  std::vector<MovingInput> files_;  ///< per input
  std::vector<std::string> open_;   ///< per input: the file that is loaded
  std::vector<LoadedObject> loaded_;
  std::map<std::string, LoadedObject> known_;  ///< by file: what need not be read at the next step
};

}  // namespace slicemorph

#pragma once

#include "io/held_input.h"
#include "slicemorph/io/input.h"
#include "slicemorph/slicemorph.h"
#include "tools/job/picture_options.h"
#include "tools/job/slice_options.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// Inputs that hosts have in memory, in the order of a job's inputs, by whose names they are among these; null, or beyond
/// the end: the input is read from its file.
using HeldInputs = std::vector<std::shared_ptr<const HeldInput>>;

/// One of them; null: it is read from its file.
inline const HeldInput* heldAt(const HeldInputs& held, size_t input) {
  return input < held.size() ? held[input].get() : nullptr;
}

/// The fields that the options of all commands are bound to, as typed: texts are parsed, and options checked
/// against each other, later. The initial values are the defaults in the help; where one only means "not
/// given" (an empty text, 0), the table (option_table.h) states the default.
struct JobOptions {
  // Inputs
  std::vector<std::string> inputs;        ///< of commands that take any number
  std::string input, other;               ///< of commands that take one; the second of `compare`
  HeldInputs held;                        ///< no option of the program
  std::optional<std::string> configText;  ///< likewise: the content of `config`, which is then only its name
  std::string iso, imageKind = "auto", spacing, upright = "auto", glbUp = "y", unit = "m", fit = "none";
  LoadOptions load;
  bool force = false;  ///< images whose geometry is not certain are read all the same

  // Shape and matching
  std::string method = "slices", pictureResolution;
  std::vector<std::string> methods;  ///< of `survey`; empty: all
  MorphOptions plan;
  std::string axis = "auto", spine = "auto", align = "auto", interpolation = "linear", landmarks,
              checkLandmarks;
  bool fogAsSurface = false;

  // Outputs
  std::string output, at, weights, keys, timing = "linear", ease = "linear", grids, sliceFolder, like, source,
                                         names, space = "auto";
  int frames = 24, start = 1;
  std::string range, planFile, usd = "auto";
  double framesPerSecond = 24;
  std::string velocity = "vel", velocityUnit = "second";
  bool conserve = false, addVelocity = false, velocityHalf = false, json = false;
  std::vector<std::string> reports;
  int every = 0, between = 0;       ///< of `reconstruct`; 0: not given
  std::string givenSlices;          ///< of `reconstruct`: numbers of slices
  double sliceTime = 0;             ///< of `slice`
  double fromTime = 0, toTime = 1;  ///< of `apply`, as the next one
  bool field = false;
  bool noPlan = false;              ///< of `pick`
  std::vector<std::string> truths;  ///< of `survey`, as the next one
  std::string tableFile;
  double factor = 1;  ///< of `retime`, as the next one
  std::string curve;

  // Pictures
  std::string exrContent = "picture";
  PictureOptions picture;
  SliceOptions slices;
  std::string contactSheet;
  int columns = 0, turntable = 0;

  // Execution
  int threads = 0;     ///< 0: as many as the machine has
  std::string memory;  ///< a size with its unit; empty: most of what is free
  bool resume = false, quiet = false, verbose = false, printConfig = false;
  std::string config;
};

}  // namespace slicemorph

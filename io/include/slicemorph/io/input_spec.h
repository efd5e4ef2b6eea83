#pragma once

#include "slicemorph/io/formats.h"

#include <string>
#include <vector>

namespace slicemorph {

/// What the text of an input says, taken apart once; all that reads takes this, not the text.
///
///     file.vdb          a file
///     file.vdb:density  one of its grids; of an image a volume (from 0), of a DICOM folder a series (from 1, or
///                       its UID), of contours a structure (its name or number)
///     name.####.vdb     a numbered sequence: one file a frame, or one a slice of an image stack
struct InputSpec {
  std::string text;       ///< as it was typed
  std::string path;       ///< the file or folder; of a sequence with its run of #
  std::string selection;  ///< what stands behind the colon; empty: nothing is chosen
  bool isSequence = false;
  Contents contents = Contents::kUnknown;
  const Format* format = nullptr;  ///< null: no format is known by this name

  bool isImage() const { return contents == Contents::kImage; }
  bool isGrids() const { return contents == Contents::kGrids; }
  /// Whether it is another object at every frame: a sequence, but not the slices of one image.
  bool isMoving() const { return isSequence && !isImage(); }
};

/// A file whose whole name exists is taken as that, whatever colons or # are in it. Nothing needs to exist; what is
/// there helps to tell folders from files and where a colon belongs to a name. Throws InputError where nothing
/// is named after the colon.
InputSpec parseInput(const std::string& text);

/// One file of a sequence as an input of its own.
struct InputFrame {
  int number = 0;
  InputSpec input;
};

/// The files of a moving input by number, each with the same selection. Throws IoError where there is none.
std::vector<InputFrame> framesOf(const InputSpec& input);

/// The files behind an input. Throws IoError where one is missing, empty or unreadable.
std::vector<std::string> filesOfInput(const InputSpec& input);

inline bool isImageInput(const std::string& text) { return parseInput(text).isImage(); }
inline bool isMovingInput(const std::string& text) { return parseInput(text).isMoving(); }

}  // namespace slicemorph

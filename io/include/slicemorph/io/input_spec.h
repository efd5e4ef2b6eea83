#pragma once

#include "slicemorph/io/formats.h"

#include <string>
#include <vector>

namespace slicemorph {

/// How one input is to be placed, by what stands in braces behind its name.
struct InputPlacing {
  double scale = 0;  ///< factor of its lengths; 0: not given
  char upright = 0;  ///< its axis that points up: 'x', 'y', 'z'; 0: not given
  std::string fit;   ///< "none", "size", "box": of this input alone; empty: not given
  std::string text;  ///< as it was typed, with the braces

  bool given() const { return scale > 0 || upright || !fit.empty(); }
};

/// An input of the command line, parsed once; readers take this instead of the text.
///
///     file.vdb          a file
///     file.vdb:density  one of its grids; of an image a volume (from 0), of a DICOM folder a series
/// (from 1, or
///                       its UID), of contours a structure (its name or number)
///     name.####.vdb     a numbered sequence: one file a frame, or one a slice of an image stack
///     name.####.vdb@10-40x2   of a sequence only these numbers, each second from 10 to 40
///     folder:2@3        of a DICOM series one volume (a time, an echo), or of a segmentation one segment
///     file.nii@0-24x2, folder:2@1-12   of an image of several volumes these, one a frame
///     file.obj{scale=0.001,upright=z}   brought to another size and upright axis as it is read
struct InputSpec {
  std::string text;       ///< as it was typed
  std::string path;       ///< the file or folder; of a sequence with its run of #
  std::string selection;  ///< the text after the colon; empty: nothing is selected
  std::string range;  ///< the text after the @ of a sequence, or of an image; empty: all files, no volumes
  InputPlacing placing;
  bool isSequence = false;
  Contents contents = Contents::kUnknown;
  const Format* format = nullptr;  ///< null: of no known format

  bool isImage() const { return contents == Contents::kImage; }
  bool isGrids() const { return contents == Contents::kGrids; }
  /// Whether every file, or volume of an image, is the object at another frame: not the slices of one image.
  bool isMoving() const { return isImage() ? !isSequence && !range.empty() : isSequence; }
};

/// Parses the text of an input. If a file of exactly that name exists, colons and # in it mean nothing. Files
/// need not exist; those that do decide what is a folder and which colons belong to a name. Throws InputError
/// where nothing follows the colon, and for ranges and braces that cannot be.
InputSpec parseInput(const std::string& text);

/// One file of a sequence as an input of its own.
struct InputFrame {
  int number = 0;
  InputSpec input;
};

/// The files, or volumes, of a moving input by number, each with the same selection and placing. Throws IoError where there
/// is no file, naming those of a range that are missing; volumes are only looked for when they are read.
std::vector<InputFrame> framesOf(const InputSpec& input);

/// An input for what takes one file: of a moving input with one file (name.####.vdb@12) that file, else the input
/// itself. Throws InputError for one of several files, IoError where there is none.
InputSpec stillInput(const InputSpec& input);

/// The files of an input: of a sequence, of a folder, or the one file. Throws IoError where one is missing,
/// empty or unreadable.
std::vector<std::string> filesOfInput(const InputSpec& input);

inline bool isImageInput(const std::string& text) { return parseInput(text).isImage(); }
inline bool isMovingInput(const std::string& text) { return parseInput(text).isMoving(); }

}  // namespace slicemorph

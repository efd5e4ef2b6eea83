#pragma once

#include "io/image/data_files.h"
#include "io/image/raw_values.h"
#include "io/image/volume_reader.h"
#include "slicemorph/io/image_file.h"

#include <map>
#include <string>
#include <vector>

namespace slicemorph {

/// An image as an NRRD header describes it.
struct NrrdHeader {
  ImageFile file;  ///< without values
  RawType type;
  std::vector<StoredAxis> axes;
  DataFiles data;
  /// Of the axes that are not of space, the fastest first: how volumes are told apart, for example "time", "RGB-color".
  std::vector<std::string> volumeKinds;
  std::map<std::string, std::string> keys;  ///< lines key:=value
  int colours = -1;                         ///< the axis that holds red, green, blue (and alpha); -1: none
};

/// Reads a header: spaces, units and kinds by the definition of the format, http://teem.sourceforge.net/nrrd/format.html;
/// positions become LPS millimetres. What the definition forbids and programs write all the same is repaired with a note.
/// `force`: see checkPlace. Throws IoError.
NrrdHeader readNrrdHeader(const std::string& path, bool force);

}  // namespace slicemorph

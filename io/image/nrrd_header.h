#pragma once

#include "io/image/raw_values.h"
#include "io/image/volume_reader.h"
#include "slicemorph/io/image_file.h"

#include <cstdint>
#include <string>
#include <vector>

namespace slicemorph {

/// Where the numbers of an NRRD file lie.
struct NrrdData {
  enum Encoding { kRaw, kText, kHex, kGzip, kBzip2 } encoding = kRaw;
  std::vector<std::string> files;  ///< that follow each other
  std::uint64_t from = 0;      ///< where the data begin in the file of the header; 0 in files of their own
  std::uint64_t lineSkip = 0;  ///< lines, then bytes, that are passed over in each file
  std::int64_t byteSkip = 0;   ///< -1: the data are the last bytes
  bool bigEndian = false;
};

/// An image as an NRRD header describes it.
struct NrrdHeader {
  ImageFile file;  ///< without values
  RawType type;
  std::vector<StoredAxis> axes;
  NrrdData data;
  /// Of the axes that are not of space, the fastest first: how volumes are told apart, for example "time", "RGB-color".
  std::vector<std::string> volumeKinds;
  int colours = -1;  ///< the axis that holds red, green, blue (and alpha); -1: none
};

/// Reads a header: spaces, units and kinds by the definition of the format, http://teem.sourceforge.net/nrrd/format.html;
/// positions become LPS millimetres. What the definition forbids and programs write all the same is repaired with a note.
/// Throws IoError.
NrrdHeader readNrrdHeader(const std::string& path);

}  // namespace slicemorph

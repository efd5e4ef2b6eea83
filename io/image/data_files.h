#pragma once

#include "io/image/raw_values.h"
#include "io/image/volume_reader.h"

#include <cstdint>
#include <string>
#include <vector>

namespace slicemorph {

/// Where the numbers of an image lie: in the file of its header or others.
struct DataFiles {
  enum Encoding { kRaw, kText, kHex, kGzip, kBzip2 } encoding = kRaw;
  std::vector<std::string> files;  ///< that follow each other
  std::uint64_t from = 0;      ///< where the data begin in the file of the header; 0 in files of their own
  std::uint64_t lineSkip = 0;  ///< lines, then bytes, that are passed over in each file
  std::int64_t byteSkip = 0;   ///< -1: the data are the last bytes
  bool bigEndian = false;
};

/// Their bytes, `bytes` of them in all and as many in each file, in the machine's byte order and as numbers even where
/// they are stored as text. `path`: of the header, for errors. Throws IoError where a file is missing, or raw and cut
/// short, before anything is read.
ByteReader openDataFiles(const std::string& path, const DataFiles& data, RawType type, std::uint64_t bytes);

/// The files that a header names, in its folder: one name, a pattern with numbers (`name.%03d.raw 1 20 1`), or the lines
/// of `list` where `given` begins with LIST. Throws IoError where they are none.
std::vector<std::string> namedDataFiles(const std::string& path, const std::string& given,
                                        const std::string& list);

}  // namespace slicemorph

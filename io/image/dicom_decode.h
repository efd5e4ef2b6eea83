#pragma once

#include "io/image/dicom_file.h"
#include "io/image/raw_values.h"

namespace slicemorph {

/// How pixels lie in memory.
struct PixelLayout {
  RawType type;
  int bitsUsed = 16, highBit = 15;
};
/// Of pixels that are stored plainly.
PixelLayout layoutOf(const DicomPixels& pixels);

/// All frames of a file that is read as a whole.
struct DecodedFile {
  PixelLayout layout;
  std::vector<char> bytes;
};
/// Unpacks compressed, deflated or big endian pixels (`DicomPixels::decode`). Throws IoError.
DecodedFile decodeFile(const DicomFile& file);

/// While one lives nothing is written to the terminal: the decoders of compressed pixels complain there of what they then
/// do right, and of what is an error here anyway.
class WithoutTerminal {
 public:
  WithoutTerminal();
  ~WithoutTerminal();
  WithoutTerminal(const WithoutTerminal&) = delete;
  WithoutTerminal& operator=(const WithoutTerminal&) = delete;

 private:
  int kept_ = -1;
};

}  // namespace slicemorph

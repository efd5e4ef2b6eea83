#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slicemorph {

/// Part of a DICOM file that its sizes say lies beyond its end, or that is none; the message names no file.
struct DicomDamage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A tag as 0xGGGGEEEE.
using DicomTag = std::uint32_t;

/// The elements of a data set, as DICOM PS3.5 section 7 and PS3.10 section 7.1 lay them down: little
/// endian, with or without value representations. Views into the file's bytes, which must live on. No size is
/// believed: GDCM's reader aborts the program on files that were cut short.
class DicomElements {
 public:
  /// Of a whole file, or of one without preamble and head. Throws DicomDamage, also where the bytes are no
  /// DICOM, or big endian or deflated as a whole. Packed pixels are walked over, not unpacked.
  static DicomElements ofFile(std::string_view bytes);

  bool has(DicomTag tag) const { return values_.count(tag) > 0; }
  /// A 16-bit whole number; -1 where there is none.
  int number(DicomTag tag) const;
  /// Length of an element's value, bytes; 0 where there is none.
  size_t size(DicomTag tag) const;
  /// Whether pixels are stored as numbers, not packed.
  bool plainPixels() const { return plainPixels_; }
  /// Without padding; empty where there is no such element.
  std::string text(DicomTag tag) const;
  /// The data sets of a sequence; none where it is absent.
  std::vector<DicomElements> items(DicomTag tag) const;

 private:
  struct Value {
    std::string_view bytes;
    bool withTypes = false;
  };
  class Walk;

  bool plainPixels_ = true;
  bool withTypes_ = false;  // value representations are written ("explicit VR")
  std::map<DicomTag, Value> values_;
};

}  // namespace slicemorph

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

/// The elements of a data set that holds no pixels, as DICOM PS3.5 section 7 and PS3.10 section 7.1 lay them down: little
/// endian, with or without value representations. Views into the file's bytes, which must live on. No size is
/// believed: GDCM's reader aborts the program on files that were cut short.
class DicomElements {
 public:
  /// Of a whole file. Throws DicomDamage also where the transfer syntax is another one.
  static DicomElements ofFile(std::string_view bytes);

  bool has(DicomTag tag) const { return values_.count(tag) > 0; }
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

  bool withTypes_ = false;  // value representations are written ("explicit VR")
  std::map<DicomTag, Value> values_;
};

}  // namespace slicemorph

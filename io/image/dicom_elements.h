#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slicemorph {

/// Bytes that are no DICOM, or DICOM whose sizes reach beyond its end; the message does not name the file.
struct DicomDamage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A tag as 0xGGGGEEEE.
using DicomTag = std::uint32_t;

/// The elements of a data set (DICOM PS3.5 section 7, PS3.10 section 7.1): little endian, with or without
/// value representations. Holds views into the file's bytes, which must outlive it. Every size is checked,
/// since GDCM's reader aborts the program on files that were cut short.
class DicomElements {
 public:
  /// Parses a whole file, with or without preamble and meta information. Throws DicomDamage, also where the
  /// bytes are no DICOM, or big endian or deflated as a whole. Compressed pixels are skipped, not decoded.
  static DicomElements ofFile(std::string_view bytes);

  bool has(DicomTag tag) const { return values_.count(tag) > 0; }
  /// A 16-bit unsigned integer; -1 where there is none.
  int number(DicomTag tag) const;
  /// Length of an element's value, bytes; 0 where there is none.
  size_t size(DicomTag tag) const;
  /// Whether pixels are stored uncompressed.
  bool plainPixels() const { return plainPixels_; }
  /// An element's text without padding; empty where there is no such element.
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

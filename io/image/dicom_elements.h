#pragma once

#include <cstdint>
#include <map>
#include <memory>
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

/// The elements of a data set (DICOM PS3.5 section 7, PS3.10 section 7.1): of either byte order, with or without
/// value representations, deflated or not. Holds views into the file's bytes, which must outlive it. Every size is
/// checked, since GDCM's reader aborts the program on files that were cut short.
class DicomElements {
 public:
  /// Parses a whole file, with or without preamble and meta information. Throws DicomDamage, also where the
  /// bytes are no DICOM. Compressed pixels are skipped, not decoded.
  static DicomElements ofFile(std::string_view bytes);
  /// The same, but of a damaged file the elements before the damage, which `damage` describes; it is empty for others.
  static DicomElements startOfFile(std::string_view bytes, std::string& damage);

  bool has(DicomTag tag) const { return values_.count(tag) > 0; }
  /// A 16-bit unsigned integer; -1 where there is none, or a number that is none.
  int number(DicomTag tag) const;
  /// An element's numbers, by the value representation that stands in the file, else by `type`: "DS" or "IS"
  /// (decimal text), "US", "SS", "UL", "SL", "AT" (as DicomTag), "FL", "FD". None where it is absent or no number.
  std::vector<double> numbers(DicomTag tag, std::string_view type = "DS") const;
  /// The first of these; `otherwise` where there is none.
  double first(DicomTag tag, std::string_view type = "DS", double otherwise = 0) const;
  /// An element's value as it is stored; empty where there is none.
  std::string_view bytes(DicomTag tag) const;
  /// The value representation that stands in the file; empty where none does.
  std::string_view type(DicomTag tag) const;
  bool bigEndian() const { return bigEndian_; }
  /// UID of the transfer syntax that the file states; empty where it states none.
  const std::string& transferSyntax() const { return transferSyntax_; }
  /// Whether the elements, and so bytes(), lie in the file's bytes as given: not where it was deflated.
  bool inFile() const { return !inflated_; }
  /// Length of an element's value, bytes; 0 where there is none.
  size_t size(DicomTag tag) const;
  /// Whether pixels are stored uncompressed.
  bool plainPixels() const { return plainPixels_; }
  /// An element's text without padding; empty where there is no such element.
  std::string text(DicomTag tag) const;
  /// The data sets of a sequence; none where it is absent.
  std::vector<DicomElements> items(DicomTag tag) const;
  /// The first of these; without elements where there is none.
  DicomElements item(DicomTag tag) const;
  /// The tags that are there, ascending.
  std::vector<DicomTag> tags() const;

 private:
  struct Value {
    std::string_view bytes;
    bool withTypes = false;
    char type[3] = "";  // the value representation, where it is written
  };
  class Walk;

  bool plainPixels_ = true;
  bool withTypes_ = false;  // value representations are written ("explicit VR")
  bool bigEndian_ = false;
  std::string transferSyntax_;
  std::shared_ptr<const std::string> inflated_;  // the bytes that the values are views of, of a deflated file
  std::map<DicomTag, Value> values_;
};

}  // namespace slicemorph

#pragma once

#include "io/image/dicom_elements.h"
#include "slicemorph/conventions.h"

#include <gdcmDataSet.h>

#include <string>
#include <vector>

namespace slicemorph {

/// Builds a DICOM data set, element by element; value representations are those of DICOM's dictionary.
class DicomSet {
 public:
  /// Any element of characters; an empty text is an element without a value.
  DicomSet& text(DicomTag tag, const std::string& value);
  /// Decimal strings of at most 16 characters, as exact as these are.
  DicomSet& decimals(DicomTag tag, const std::vector<double>& values);
  DicomSet& point(DicomTag tag, const Vec3d& p) { return decimals(tag, {p[0], p[1], p[2]}); }
  /// Binary numbers of 16 or 32 bits.
  DicomSet& shorts(DicomTag tag, const std::vector<std::uint16_t>& values);
  DicomSet& longs(DicomTag tag, const std::vector<std::uint32_t>& values);
  /// The tag of another element.
  DicomSet& pointer(DicomTag tag, DicomTag to);
  DicomSet& bytes(DicomTag tag, const std::string& value);
  DicomSet& items(DicomTag tag, const std::vector<DicomSet>& sets);
  /// A sequence of one item.
  DicomSet& item(DicomTag tag, const DicomSet& set) { return items(tag, {set}); }
  /// A sequence of one code.
  DicomSet& code(DicomTag tag, const char* value, const char* scheme, const char* meaning);

  /// A whole file. Implicit value representations allow texts of any length. Throws IoError.
  std::string file(bool implicit) const;

 private:
  void add(DicomTag tag, std::string value, char padding);

  gdcm::DataSet set_;
};

/// The shortest decimal string of at most 16 characters that is nearest to a number.
std::string decimalString(double value);

/// UIDs that are made of a content: name-based UUIDs (RFC 4122, version 3) under the root 2.25 (DICOM PS3.5 B.2).
class ContentUids {
 public:
  explicit ContentUids(const std::string& content);
  /// The UID of one of the things that the content is about, by a name.
  std::string of(const std::string& thing) const;

 private:
  std::string digest_;
};

}  // namespace slicemorph

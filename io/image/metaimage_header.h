#pragma once

#include "slicemorph/note.h"

#include <cstdint>
#include <map>
#include <string>
#include <utility>

namespace slicemorph {

/// The `key = value` lines of a MetaImage header and where its data begin.
struct MetaHeader {
  std::map<std::string, std::string> value;
  std::uint64_t bytes = 0;

  bool has(const char* key) const { return value.count(key) > 0; }
  std::string text(const char* key) const { return has(key) ? value.at(key) : std::string(); }
  /// Throws IoError, naming it, where what an image needs is missing.
  void check(const std::string& path) const;
  /// Whether a key says True.
  bool is(const char* key) const;
  bool bigEndian() const { return is("BinaryDataByteOrderMSB") || is("ElementByteOrderMSB"); }
  /// Whether the data are in one file, by the name that the header gives.
  bool inOneFile() const;
  /// The file that the data are in; the header's own `path` where they follow it.
  std::string dataFile(const std::string& path) const;
  /// Factor and summand (ElementToIntensityFunctionSlope, ...Offset) that make stored numbers values; 1 and 0 where the
  /// header has none. Throws IoError where they are no numbers.
  std::pair<double, double> scale(const std::string& path) const;
  Note scaleNote() const;
};

/// Throws IoError where a file has no such header.
MetaHeader metaHeaderOf(const std::string& path);

}  // namespace slicemorph

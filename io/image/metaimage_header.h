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
  std::string list;  ///< the lines behind the header, where its data are in the files that they name
  std::uint64_t bytes = 0;

  bool has(const char* key) const { return value.count(key) > 0; }
  std::string text(const char* key) const { return has(key) ? value.at(key) : std::string(); }
  /// Throws IoError, naming it, where what an image needs is missing.
  void check(const std::string& path) const;
  /// Whether a key says True.
  bool is(const char* key) const;
  bool bigEndian() const { return is("BinaryDataByteOrderMSB") || is("ElementByteOrderMSB"); }
  /// Whether the data follow the header.
  bool isLocal() const;
  /// Factor and summand (ElementToIntensityFunctionSlope, ...Offset) that make stored numbers values; 1 and 0 where the
  /// header has none. Throws IoError where they are no numbers.
  std::pair<double, double> scale(const std::string& path) const;
  Note scaleNote() const;
};

/// Throws IoError where a file has no such header.
MetaHeader metaHeaderOf(const std::string& path);

}  // namespace slicemorph

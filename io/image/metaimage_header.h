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
  /// The whole number of a key from `least` to `most`, or `otherwise` where the header has none. Throws IoError, naming
  /// them, for others.
  std::int64_t whole(const std::string& path, const char* key, std::int64_t otherwise, std::int64_t least,
                     std::int64_t most) const;
  /// Bytes that are passed over before the data of each file; -1: the data are its last bytes.
  std::int64_t skipped(const std::string& path) const;
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

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace slicemorph {

/// The fields of an NRRD header that are read before the library sees it, and the rest as text.
struct NrrdText {
  std::map<std::string, std::string> fields;  ///< names in lower case; of all fields
  std::map<std::string, std::string> keys;    ///< of lines key:=value, as they stand in the file
  std::string dataFiles;                      ///< the lines after `data file: LIST`
  std::string rest;                           ///< a header without the fields that say where data are
  std::string dropped;    ///< fields that tell of axes with directions what may not stand there
  std::uint64_t end = 0;  ///< where the data begin in the file

  std::string field(const std::string& name) const {
    const auto at = fields.find(name);
    return at == fields.end() ? std::string() : at->second;
  }
  /// Whether an axis has a direction; there are headers in which all have none.
  bool hasDirections() const { return field("space directions").find('(') != std::string::npos; }
};

/// The words of a field as `units`: each in quotes, or up to a blank.
std::vector<std::string> quotedWords(const std::string& text);

/// Splits the header of a file. Throws IoError where it is no NRRD file.
NrrdText readNrrdText(const std::string& path);

}  // namespace slicemorph

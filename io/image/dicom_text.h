#pragma once

#include <string>

namespace slicemorph {

/// A text of a DICOM file as UTF-8.
struct DicomText {
  std::string text;
  bool lost = false;  ///< it has letters that cannot be told, which became question marks
};

/// Makes a text UTF-8. `characters`: SpecificCharacterSet (PS3.3 C.12.1.1.2) as it stands in the file: of its first set,
/// and of Japanese texts that switch between sets (PS3.5 annex H); texts that switch otherwise are lost. Where the file
/// names no set, a text that is UTF-8 is taken as such, else as Latin-1, though only ASCII is allowed there.
DicomText utf8OfDicom(const std::string& text, const std::string& characters);

}  // namespace slicemorph

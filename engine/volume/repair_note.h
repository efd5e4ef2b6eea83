#pragma once

#include "slicemorph/note.h"

#include <sstream>
#include <string>
#include <utility>

namespace slicemorph {

/// "1 hole", "2 holes".
inline std::string countOf(size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// A number with so many digits.
inline std::string withDigits(double value, int digits) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

inline Note repairNote(const char* code, Severity severity, std::string text) {
  return {code, severity, "", std::move(text)};
}

}  // namespace slicemorph

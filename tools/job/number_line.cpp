#include "tools/job/number_line.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace slicemorph {

NumberLine numberLine(std::string line) {
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
  std::istringstream stream(line);
  NumberLine parts;
  for (std::string word; stream >> word;) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    const bool isNumber = *end == 0 && std::isfinite(number);
    if (parts.empty()) parts.wordFirst = !isNumber;
    if (isNumber)
      parts.numbers.push_back(number);
    else
      parts.words.push_back(word);
  }
  return parts;
}

}  // namespace slicemorph

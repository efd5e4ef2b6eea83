#pragma once

#include <string>
#include <vector>

namespace slicemorph {

/// A line of a text file of numbers, split at blanks, commas and semicolons.
struct NumberLine {
  std::vector<double> numbers;     ///< finite
  std::vector<std::string> words;  ///< items that are no finite numbers
  bool wordFirst = false;          ///< the line begins with a word, as headings do

  bool empty() const { return numbers.empty() && words.empty(); }
};
NumberLine numberLine(std::string line);

}  // namespace slicemorph

#pragma once

#include <string>
#include <vector>

namespace slicemorph {

/// A line of a text file of numbers, which are separated by blanks, commas or semicolons.
struct NumberLine {
  std::vector<double> numbers;     ///< finite
  std::vector<std::string> words;  ///< what is no number
  bool wordFirst = false;          ///< the line begins with a word, as headings do

  bool empty() const { return numbers.empty() && words.empty(); }
};
NumberLine numberLine(std::string line);

}  // namespace slicemorph

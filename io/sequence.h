#pragma once

#include <string>
#include <vector>

namespace slicemorph {

/// One file of a numbered sequence.
struct SequenceFile {
  int number = 0;
  std::string path;
};

/// The numbers of a range: `10-40x2,50` is 10, 12 ... 40 and 50; ascending, each once. A step may also be written
/// `10-40:2`, and numbers may be negative: `-5--1`. None where the text is no range, or has more than a million
/// numbers.
std::vector<int> numbersOfRange(const std::string& text);

/// Numbers for messages: "3, 5-7", of many the first.
std::string listOfNumbers(const std::vector<int>& numbers);

/// Numbers between the first and the last file that no file has; of files that are evenly spaced those on their way.
std::vector<int> missingNumbers(const std::vector<SequenceFile>& files);

/// The files that a name with a run of # stands for (`smoke.####.vdb`: smoke.0001.vdb, smoke.0002.vdb ...),
/// by number; with a range only those of it. Throws IoError where there is none, or one of the range is missing.
std::vector<SequenceFile> findSequence(const std::string& pattern, const std::string& range = "");

}  // namespace slicemorph

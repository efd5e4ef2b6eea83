#include "tools/job/frame_range.h"

#include "io/sequence.h"

#include <algorithm>

namespace slicemorph {

void keepRange(std::vector<FrameJob>& frames, const OptionSet& options) {
  if (!options.given("range")) return;
  const std::string &range = options.values().range, said = "--range " + range;
  const std::vector<int> numbers = numbersOfRange(range);
  if (numbers.empty())
    options.refuse("range", said +
                                " is no range of frames; expected for example 1005-1012, each fifth of "
                                "1 to 100 as 1-100x5 or 1-100:5, or 1-3,5,7-20x2");
  for (FrameJob& frame : frames)
    frame.wanted = std::binary_search(numbers.begin(), numbers.end(), frame.number);
  const int first = frames.front().number, last = frames.back().number;
  std::vector<int> outside;
  for (int number : numbers)
    if (number < first || number > last) outside.push_back(number);
  if (!outside.empty() && !options.values().printConfig)
    options.refuse("range", said + ": " + (outside.size() == 1 ? "frame " : "frames ") +
                                listOfNumbers(outside) + (outside.size() == 1 ? " is" : " are") +
                                " none of this sequence, which has " + std::to_string(first) + " to " +
                                std::to_string(last) + " (--start, --frames and the inputs' lengths say so)");
}

}  // namespace slicemorph

#pragma once

#include "slicemorph/progress.h"

#include <cstdint>
#include <string>
#include <vector>

namespace slicemorph {

/// How a program that was run as a process of its own ended, and what it took.
struct ChildEnd {
  bool done = false;  ///< it ended with code 0
  std::string said;   ///< on its standard error
  std::string
      trouble;  ///< how it ended otherwise than by itself: "ended by signal 9 (Killed)"; empty: it did not
  double seconds = 0, processorSeconds = 0;
  /// The most memory that it held; not below what this process had held when it started the other, which Linux counts for
  /// both.
  std::int64_t peakBytes = 0;
};

/// Runs this program with other arguments, its standard output unread, and waits for its end. Where `cancel` says so the
/// other is ended and Cancelled thrown. Throws IoError where it cannot be started.
ChildEnd runOwnProgram(const std::vector<std::string>& arguments, const Progress& cancel);

}  // namespace slicemorph

#pragma once

#include "slicemorph/errors.h"

#include <string>

/// How much memory the program may take. Sizes are in bytes, and numbers with a fraction, since estimates may go
/// beyond all integers.
namespace slicemorph {

/// What was asked for needs more memory than may be taken. The message says how much, and what to change.
struct MemoryError : Error {
  using Error::Error;
};

/// What could be taken more without swapping or being ended: the least of what the machine has available, and what the
/// limits of its control groups and of the process (RLIMIT_AS, RLIMIT_DATA) leave. What is not known does not
/// limit. `root`: where `proc` and `sys` are, for tests.
double freeMemory(const std::string& root = "");
/// What the process has taken.
double takenMemory();

/// For messages: "512 MB", "1.4 GB", in steps of 1024.
std::string describeBytes(double bytes);
/// Reads `4G`, `500M`, `1.5 GB`, `2GiB`, in steps of 1024, or `60%`, of `free`. Throws InputError, with `option` in
/// front.
double parseBytes(const std::string& option, const std::string& text, double free);

/// A limit for the whole process.
struct MemoryLimit {
  double bytes = 0;  ///< 0: none

  /// What is left of it; without a limit infinity.
  double left() const;
  /// Throws MemoryError where more than what is left would be needed. `about`: the file or option; `what`: what needs
  /// it; `advice`: what to change, part of a sentence, as "use a larger --voxel-size".
  void require(double needed, const std::string& about, const std::string& what,
               const std::string& advice) const;
  /// Makes the system refuse what is beyond it, which then throws std::bad_alloc. Leaves a stricter limit of the
  /// system as it is.
  void enforce() const;
};

}  // namespace slicemorph

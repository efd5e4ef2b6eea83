#pragma once

#include "io/file_claim.h"
#include "tools/job/resume_log.h"

#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// Keeps two processes from making one frame: the one that comes second leaves it to the first. Frames are claimed one
/// by one while they are made (see FileClaim), so that ranges may overlap.
class FrameClaims {
 public:
  FrameClaims(const MorphSettings& settings, ResumeLog& log) : settings_(settings), log_(log) {}

  /// Claims a frame, or the one file of all. False where another process makes it, or has made it since this run
  /// began. Throws IoError where the other's frame is of other settings or inputs, which would write over each other's.
  bool take(const FrameJob& job);
  /// To be called when the frame is written and in the log.
  void free() { claim_.reset(); }

  /// A note on the frames that were left to others; none where there are none. Throws IoError where some of them are
  /// not there, and no process that is known to live makes them.
  Notes finish();

 private:
  const MorphSettings& settings_;
  ResumeLog& log_;
  std::unique_ptr<FileClaim> claim_;
  std::vector<FrameJob> left_;  ///< to others
  std::string owner_;           ///< the first of them; empty: not known
};

}  // namespace slicemorph

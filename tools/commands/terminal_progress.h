#pragma once

#include "slicemorph/progress.h"
#include "tools/job/time_left.h"

#include <chrono>
#include <mutex>
#include <string>

namespace slicemorph {

/// From now on the first Ctrl-C, SIGTERM or, where it is not ignored, SIGHUP sets TerminalProgress::cancelled; the next
/// one ends the program at once.
void cancelOnInterrupt();

/// One line on stderr, redrawn in place: stage, percentage, time left. The percentage never goes back. Silent unless stderr
/// is a terminal.
class TerminalProgress : public Progress {
 public:
  explicit TerminalProgress(bool quiet);
  ~TerminalProgress() override;

  void report(const char* stage, double fraction) override;
  /// Jobs ask often, also where they have nothing to report for long: the time left is counted down here.
  bool cancelled() const override;
  /// Removes the line, so that other output does not run into it.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  double now() const;
  void draw() const;

  const bool shown_;
  const Clock::time_point start_ = Clock::now();
  mutable std::mutex mutex_;
  std::string stage_;
  TimeLeft left_;
  mutable double lastDrawn_ = -1;  ///< seconds since the start
  mutable size_t width_ = 0;       ///< of the line on the screen
};

}  // namespace slicemorph

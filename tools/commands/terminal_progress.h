#pragma once

#include "slicemorph/progress.h"

#include <chrono>
#include <mutex>
#include <string>

namespace slicemorph {

/// From now on the first Ctrl-C or SIGTERM sets TerminalProgress::cancelled; the next one ends the
/// program at once.
void cancelOnInterrupt();

/// One line on stderr, redrawn in place: stage, percentage, time left. Silent unless stderr is a terminal.
class TerminalProgress : public Progress {
 public:
  explicit TerminalProgress(bool quiet);
  ~TerminalProgress() override;

  void report(const char* stage, double fraction) override;
  bool cancelled() const override;
  /// Removes the line, so that other output does not run into it.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  std::string timeLeft(Clock::time_point now, double fraction) const;

  const bool shown_;
  std::mutex mutex_;
  std::string stage_;
  double stageFraction_ = 0;  ///< fraction at which the stage began
  Clock::time_point stageStart_, lastDrawn_;
  size_t width_ = 0;  ///< of the line on the screen
};

}  // namespace slicemorph

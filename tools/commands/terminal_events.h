#pragma once

#include "tools/commands/terminal_progress.h"
#include "tools/job/job_events.h"

namespace slicemorph {

/// Shows a job's events on the terminal: progress and notes on stderr, the names of finished files on
/// stdout. `quiet`: shows nothing; `verbose`: also shows how decisions were reached. The first Ctrl-C ends
/// the job cleanly.
class TerminalEvents : public JobEvents {
 public:
  explicit TerminalEvents(bool quiet, bool verbose = false);

  void report(const char* stage, double fraction) override { progress_.report(stage, fraction); }
  bool cancelled() const override { return progress_.cancelled(); }
  void note(const Note& note) override;
  void fileWritten(const std::string& path, bool kept) override;
  /// Removes the progress, so that other output does not run into it.
  void clear() { progress_.clear(); }

 private:
  const bool quiet_, verbose_;
  TerminalProgress progress_;
};

}  // namespace slicemorph

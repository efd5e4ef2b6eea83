#pragma once

#include "tools/commands/terminal_progress.h"
#include "tools/job/job_events.h"

#include <chrono>
#include <mutex>
#include <string>

namespace slicemorph {

/// Tells a job's events as Slicer listens to them: progress in its tags on standard output, where notes and the names of
/// files go, too, since Slicer shows whatever is on standard error as an error. SIGINT and SIGTERM end the job cleanly.
class SlicerEvents : public JobEvents {
 public:
  explicit SlicerEvents(const std::string& filter);

  void report(const char* stage, double fraction) override;
  bool cancelled() const override { return interrupts_.cancelled(); }
  void note(const Note& note) override;
  void fileWritten(const std::string& path, bool kept) override;
  /// The job is done.
  void finish();

  /// All notes in one line.
  const std::string& remarks() const { return remarks_; }

 private:
  using Clock = std::chrono::steady_clock;

  const std::string filter_;
  const Clock::time_point start_ = Clock::now();
  TerminalProgress interrupts_{/*quiet=*/true};
  std::mutex mutex_;
  std::string stage_, remarks_;
  double told_ = 0;  ///< what was reported last; it never goes back
};

/// Passes events on, but throws InputError where an image holds several volumes, of which a job takes the first: of a
/// segmentation with layers that would be some of its segments, unasked.
class WholeImages : public JobEvents {
 public:
  explicit WholeImages(JobEvents& to) : to_(to) {}
  void report(const char* stage, double fraction) override { to_.report(stage, fraction); }
  bool cancelled() const override { return to_.cancelled(); }
  void note(const Note& note) override;
  void fileWritten(const std::string& path, bool kept) override { to_.fileWritten(path, kept); }

 private:
  JobEvents& to_;
};

/// A part of a job as a job of its own: its fractions 0 to 1 become `from` to `to` of the whole.
class PartEvents : public JobEvents {
 public:
  PartEvents(JobEvents& whole, double from, double to) : whole_(whole), from_(from), to_(to) {}
  void report(const char* stage, double fraction) override {
    whole_.report(stage, from_ + (to_ - from_) * fraction);
  }
  bool cancelled() const override { return whole_.cancelled(); }
  void note(const Note& note) override { whole_.note(note); }
  void fileWritten(const std::string& path, bool kept) override { whole_.fileWritten(path, kept); }

 private:
  JobEvents& whole_;
  double from_, to_;
};

}  // namespace slicemorph

#pragma once

#include "slicemorph/errors.h"
#include "slicemorph/note.h"
#include "slicemorph/progress.h"

#include <string>

namespace slicemorph {

/// What a job reports to its caller while it runs, and the caller's way to cancel it; the default does
/// nothing. Notes and files come from the thread that runs the job, progress from any thread.
class JobEvents : public Progress {
 public:
  /// Reports something that was found, decided or changed.
  virtual void note(const Note& note) { (void)note; }
  /// Reports an output that is complete. `kept`: it exists from an earlier run of the same job.
  virtual void fileWritten(const std::string& path, bool kept) { (void)path, (void)kept; }

  void notes(const Notes& notes) {
    for (const Note& one : notes) note(one);
  }
  /// Throws Cancelled.
  void throwIfCancelled() const {
    if (cancelled()) throw Cancelled();
  }
};

/// Passes events on and keeps the notes.
class NoteKeeper : public JobEvents {
 public:
  explicit NoteKeeper(JobEvents& caller) : caller_(caller) {}
  void report(const char* stage, double fraction) override { caller_.report(stage, fraction); }
  bool cancelled() const override { return caller_.cancelled(); }
  void note(const Note& note) override { caller_.note(note), kept_.push_back(note); }
  void fileWritten(const std::string& path, bool kept) override { caller_.fileWritten(path, kept); }
  const Notes& kept() const { return kept_; }

 private:
  JobEvents& caller_;
  Notes kept_;
};

/// Progress of a part of a larger job: fractions 0 to 1 become `from` to `to` of the whole.
class PartProgress : public Progress {
 public:
  PartProgress(Progress& whole, double from, double to) : whole_(whole), from_(from), to_(to) {}
  void report(const char* stage, double fraction) override {
    whole_.report(stage, from_ + (to_ - from_) * fraction);
  }
  bool cancelled() const override { return whole_.cancelled(); }

 private:
  Progress& whole_;
  double from_, to_;
};

/// Passes on cancellation only, and no reports.
class OnlyCancel : public Progress {
 public:
  explicit OnlyCancel(const Progress& of) : of_(of) {}
  bool cancelled() const override { return of_.cancelled(); }

 private:
  const Progress& of_;
};

}  // namespace slicemorph

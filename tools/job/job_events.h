#pragma once

#include "slicemorph/errors.h"
#include "slicemorph/note.h"
#include "slicemorph/progress.h"

#include <string>

namespace slicemorph {

/// What a job tells its caller while it runs, and the caller's way to end it; the default does nothing. Notes
/// and files come from the thread that runs the job, progress from any.
class JobEvents : public Progress {
 public:
  /// Something was found, decided or changed.
  virtual void note(const Note& note) { (void)note; }
  /// An output is complete. `kept`: it was there already, from an earlier run of the same job.
  virtual void fileWritten(const std::string& path, bool kept) { (void)path, (void)kept; }

  void notes(const Notes& notes) {
    for (const Note& one : notes) note(one);
  }
  /// Throws Cancelled.
  void throwIfCancelled() const {
    if (cancelled()) throw Cancelled();
  }
};

/// A part of a larger job: fractions 0 to 1 become `from` to `to` of the whole.
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

/// Passes nothing on but that the job is to end.
class OnlyCancel : public Progress {
 public:
  explicit OnlyCancel(const Progress& of) : of_(of) {}
  bool cancelled() const override { return of_.cancelled(); }

 private:
  const Progress& of_;
};

}  // namespace slicemorph

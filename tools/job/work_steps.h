#pragma once

#include "tools/job/job_events.h"

#include <cstddef>
#include <vector>

namespace slicemorph {

/// The steps of a job, one after another, each with the time that it is expected to take, in any unit. What they are of
/// the whole job is told as fractions, for its progress.
class WorkSteps {
 public:
  /// Adds a step of that cost at the end, and returns its number.
  size_t add(double cost) {
    ends_.push_back(end() + cost);
    return ends_.size() - 1;
  }
  /// Fractions of the whole at which a step begins and ends. To be asked when all are added.
  double from(size_t step) const { return end() > 0 && step > 0 ? ends_[step - 1] / end() : 0; }
  double to(size_t step) const { return end() > 0 ? ends_[step] / end() : 1; }

 private:
  double end() const { return ends_.empty() ? 0 : ends_.back(); }
  std::vector<double> ends_;
};

/// Passes on what one step tells: its progress, 0 to 1, as that of the whole, and notes, but no names of files.
class StepEvents : public JobEvents {
 public:
  StepEvents(JobEvents& whole, const WorkSteps& steps, size_t step)
      : whole_(whole), part_(whole, steps.from(step), steps.to(step)) {}
  void report(const char* stage, double fraction) override { part_.report(stage, fraction); }
  bool cancelled() const override { return whole_.cancelled(); }
  void note(const Note& note) override { whole_.note(note); }

 private:
  JobEvents& whole_;
  PartProgress part_;
};

}  // namespace slicemorph

#pragma once

#include <map>
#include <optional>
#include <string>

namespace slicemorph {

/// Estimates from a job's progress how long it will still take. Fractions that go back, as they may where threads
/// report, count as no progress. Times are in seconds since the job began, and do not go back.
class TimeLeft {
 public:
  /// Takes a report of the job: a stage, and the fraction of the whole that is done.
  void report(const std::string& stage, double fraction, double now);
  /// The highest fraction so far.
  double fraction() const { return fraction_; }
  /// Seconds from `now` to the job's end; none where nothing can be told yet, or the job is later than was thought.
  std::optional<double> at(double now) const;

 private:
  struct Moment {
    double time = 0, fraction = 0;
  };
  double estimated() const;

  std::map<std::string, Moment> begins_;  ///< of each stage the first report
  Moment newest_;                         ///< the first report of the stage that was new last
  double fraction_ = 0;
  Moment last_;           ///< the last report that brought the job on
  double duration_ = -1;  ///< estimated seconds from the job's begin to its end; negative: none
};

}  // namespace slicemorph

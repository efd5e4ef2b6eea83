#include "tools/job/time_left.h"

#include <algorithm>

namespace slicemorph {
namespace {

/// Nothing is told before a job has run for so many seconds, and done such a share of its work.
constexpr double kLeastTime = 1, kLeastShare = 0.01;
/// The share of the job after which the speed of the newest stage counts as much as that of the whole. Jobs know their
/// stages' shares roughly (work_steps.h): what is planned for long may have frames that are made quickly. A frame of 24 is
/// about a thirtieth of a job.
constexpr double kTrusted = 0.02;

}  // namespace

void TimeLeft::report(const std::string& stage, double fraction, double now) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  // Jobs that plan again for each frame come back to their stages: from then on nothing is new, and the speed is that of
  // all stages in turn.
  if (begins_.emplace(stage, Moment{now, std::max(fraction, fraction_)}).second) newest_ = begins_.at(stage);
  if (fraction <= fraction_) return;
  fraction_ = fraction;
  last_ = {now, fraction};
  if (now < kLeastTime || fraction < kLeastShare) return;
  duration_ = now + estimated();
}

/// Seconds from the last report to the end.
double TimeLeft::estimated() const {
  const double left = 1 - last_.fraction, byWhole = left * last_.time / last_.fraction;
  const double share = last_.fraction - newest_.fraction;
  if (share <= 0) return byWhole;
  const double byStage = left * (last_.time - newest_.time) / share, weight = share / (share + kTrusted);
  return weight * byStage + (1 - weight) * byWhole;
}

std::optional<double> TimeLeft::at(double now) const {
  if (duration_ < 0 || now > duration_) return std::nullopt;
  return duration_ - now;
}

}  // namespace slicemorph

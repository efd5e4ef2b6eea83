#pragma once

#include <limits>
#include <vector>

namespace slicemorph {

/// The lower envelope of the parabolas height + unit (x - apex)^2 over the integers of a line. In a separable
/// distance transform it finds which apex is nearest once the squared distances along this axis are added to
/// those along the others ([FH12], linear in the length of the line). Used by all distance transforms.
/// `Real`: type in which intersections of parabolas are computed.
template <typename Real>
class LowerEnvelope {
 public:
  /// `unit`: squared distance between consecutive integers of the line.
  LowerEnvelope(int longest, Real unit)
      : apex_(size_t(longest)),
        from_(size_t(longest)),
        lifted_(size_t(longest)),
        unit_(unit),
        inverse_(1 / (2 * unit)) {}

  void clear() { top_ = -1, current_ = 0; }
  bool empty() const { return top_ < 0; }

  /// Adds a parabola; `apex` must be to the right of all earlier ones.
  void add(int apex, Real height) {
    constexpr Real kBeforeAll = std::numeric_limits<Real>::lowest();
    const Real lifted = height + unit_ * Real(apex) * Real(apex);
    Real from = kBeforeAll;
    while (top_ >= 0) {
      from = (lifted - lifted_[size_t(top_)]) * inverse_ / Real(apex - apex_[size_t(top_)]);
      if (from > from_[size_t(top_)]) break;
      --top_, from = kBeforeAll;
    }
    ++top_;
    apex_[size_t(top_)] = apex, from_[size_t(top_)] = from, lifted_[size_t(top_)] = lifted;
  }

  /// The apex of the lowest parabola at `x`. From call to call `x` must not decrease.
  /// Precondition: not empty().
  int nearest(int x) {
    while (current_ < top_ && from_[size_t(current_) + 1] < Real(x)) ++current_;
    return apex_[size_t(current_)];
  }

 private:
  std::vector<int> apex_;
  std::vector<Real> from_, lifted_;  ///< where each becomes the lowest; its height at 0
  Real unit_, inverse_;
  int top_ = -1, current_ = 0;
};

}  // namespace slicemorph

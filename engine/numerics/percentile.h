#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace slicemorph {

/// The value below which a share (0 to 1) of values lies, linear between the two nearest. `values`: at least one; they are put
/// in another order.
template <typename T>
double percentileOf(std::vector<T>& values, double share) {
  const double at = share * double(values.size() - 1);
  const auto low = values.begin() + std::ptrdiff_t(at);
  std::nth_element(values.begin(), low, values.end());
  const auto next = low + 1 == values.end() ? low : std::min_element(low + 1, values.end());
  return double(*low) + (at - double(std::ptrdiff_t(at))) * (double(*next) - double(*low));
}

}  // namespace slicemorph

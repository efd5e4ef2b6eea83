#include "io/image/label_values.h"

#include "engine/volume/image_shape.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace slicemorph {
namespace {

constexpr double kLabelTolerance = 1e-3;

template <typename T>
bool isNearlyLabel(T value) {
  const double v = double(value);
  return v > -0.5 && v <= 2147483647.0 && std::abs(v - std::rint(v)) <= kLabelTolerance;
}

/// How many values are to be rounded; 0 where one is no label.
template <typename T>
size_t countToRound(const std::vector<T>& values) {
  if (std::is_integral_v<T> || !std::all_of(values.begin(), values.end(), isNearlyLabel<T>)) return 0;
  return size_t(
      std::count_if(values.begin(), values.end(), [](T v) { return double(v) != std::rint(double(v)); }));
}

}  // namespace

void takeLabels(Image& image, bool asked, Notes& notes) {
  const size_t count = std::visit([](const auto& values) { return countToRound(values); }, image.values);
  if (count == 0) return;
  Image whole{image.lattice, std::visit(
                                 [](const auto& values) -> ImageValues {
                                   std::decay_t<decltype(values)> rounded(values.size());
                                   std::transform(values.begin(), values.end(), rounded.begin(), [](auto v) {
                                     return decltype(v)(std::abs(std::rint(double(v))));
                                   });
                                   return rounded;
                                 },
                                 image.values)};
  if (!asked && !looksLikeLabels(whole)) return;
  image = std::move(whole);
  notes.emplace_back(
      "image.labels-rounded", Severity::kNote, "",
      std::to_string(count) + " of its labels are whole numbers but for 0.001 at most: rounded");
}

}  // namespace slicemorph

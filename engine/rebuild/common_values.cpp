#include "engine/rebuild/common_values.h"

#include "engine/volume/image_sampler.h"

#include <algorithm>

namespace slicemorph {

ImageValues commonValues(const std::vector<const Image*>& images, size_t count) {
  bool same = true, whole = true, wide = false, negative = false, large = false;
  for (const Image* image : images) {
    const size_t type = image->values.index();
    same &= type == images[0]->values.index();
    whole &= type <= 3, wide |= type == 3 || type == 5, negative |= type == 1 || type == 3,
        large |= type == 2 || type == 3;
  }
  if (same) {
    return std::visit([&](const auto& v) -> ImageValues { return std::decay_t<decltype(v)>(count); },
                      images[0]->values);
  }
  if (!whole) return wide ? ImageValues(std::vector<double>(count)) : ImageValues(std::vector<float>(count));
  if (wide || (negative && large)) return std::vector<std::int32_t>(count);
  return negative ? ImageValues(std::vector<std::int16_t>(count))
                  : ImageValues(std::vector<std::uint16_t>(count));
}

ImageValues valuesAs(const ImageValues& values, const ImageValues& like) {
  return std::visit(
      [](const auto& from, const auto& type) -> ImageValues {
        using T = typename std::decay_t<decltype(type)>::value_type;
        std::vector<T> to(from.size());
        std::transform(from.begin(), from.end(), to.begin(),
                       [](auto value) { return storedValue<T>(double(value)); });
        return to;
      },
      values, like);
}

void storeRow(const std::vector<double>& row, size_t first, ImageValues& values) {
  std::visit(
      [&](auto& out) {
        using T = typename std::decay_t<decltype(out)>::value_type;
        std::transform(row.begin(), row.end(), out.begin() + std::ptrdiff_t(first), storedValue<T>);
      },
      values);
}

}  // namespace slicemorph

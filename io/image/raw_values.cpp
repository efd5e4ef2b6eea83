#include "io/image/raw_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace slicemorph {
namespace {

template <typename T>
ImageValues direct(size_t count, const std::function<void(void*)>& read) {
  std::vector<T> values(count);
  read(values.data());
  return values;
}

template <typename To, typename From>
std::vector<To> converted(const std::vector<From>& from) {
  std::vector<To> to(from.size());
  std::transform(from.begin(), from.end(), to.begin(), [](From v) { return To(v); });
  return to;
}

using Range = std::pair<double, double>;

/// The least and the largest of all values, or of all that their type can hold.
template <typename T>
Range rangeOf(const std::vector<T>& values, TypeBy by) {
  if (by == TypeBy::kRange)
    return {double(std::numeric_limits<T>::min()), double(std::numeric_limits<T>::max())};
  if (values.empty()) return {0, 0};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {double(*low), double(*high)};
}

template <typename T>
bool fitsIn(const Range& range) {
  return range.first >= double(std::numeric_limits<T>::min()) &&
         range.second <= double(std::numeric_limits<T>::max());
}

ImageValues signedBytes(size_t count, const std::function<void(void*)>& read) {
  std::vector<std::int8_t> values(count);
  read(values.data());
  return converted<std::int16_t>(values);
}

template <typename From>
ImageValues whole(size_t count, const std::function<void(void*)>& read, TypeBy by) {
  std::vector<From> values(count);
  read(values.data());
  if (fitsIn<std::int32_t>(rangeOf(values, by))) return converted<std::int32_t>(values);
  return converted<double>(values);
}

template <typename To, typename From>
std::vector<To> scaled(const std::vector<From>& from, double slope, double intercept) {
  std::vector<To> to(from.size());
  std::transform(from.begin(), from.end(), to.begin(),
                 [&](From v) { return To(double(v) * slope + intercept); });
  return to;
}

}  // namespace

ImageValues readValues(RawType type, size_t count, const std::function<void(void*)>& read, TypeBy by) {
  if (type.kind == RawType::kFloat)
    return type.bytes == 8 ? direct<double>(count, read) : direct<float>(count, read);
  const bool negative = type.kind == RawType::kSigned;
  switch (type.bytes) {
    case 1:
      return negative ? signedBytes(count, read) : direct<std::uint8_t>(count, read);
    case 2:
      return negative ? direct<std::int16_t>(count, read) : direct<std::uint16_t>(count, read);
    case 4:
      return negative ? direct<std::int32_t>(count, read) : whole<std::uint32_t>(count, read, by);
    default:
      return negative ? whole<std::int64_t>(count, read, by) : whole<std::uint64_t>(count, read, by);
  }
}

ImageValues noValues(RawType type, TypeBy by) {
  return readValues(
      type, 0, [](void*) {}, by);
}

size_t bytesWhileRead(RawType type, bool scaled) {
  const RawType as = rawTypeOf(noValues(type, TypeBy::kRange));
  const bool same = as.bytes == type.bytes && as.kind == type.kind;
  const int reading = type.bytes + (same ? 0 : as.bytes);
  const bool wide = as.bytes == 8 || (as.bytes == 4 && as.kind != RawType::kFloat);
  return size_t(scaled ? std::max(reading, as.bytes + (wide ? 8 : 4)) : reading);
}

ImageValues rescaled(ImageValues values, double slope, double intercept, TypeBy by) {
  if (slope == 1 && intercept == 0) return values;
  return std::visit(
      [&](auto& from) -> ImageValues {
        using T = typename std::decay_t<decltype(from)>::value_type;
        if constexpr (std::is_same_v<T, double>) return scaled<double>(from, slope, intercept);
        if constexpr (std::is_integral_v<T>) {
          if (slope == std::rint(slope) && intercept == std::rint(intercept)) {
            const auto [least, most] = rangeOf(from, by);
            const Range range = std::minmax({least * slope + intercept, most * slope + intercept});
            if (fitsIn<std::int16_t>(range)) return scaled<std::int16_t>(from, slope, intercept);
            if (fitsIn<std::uint16_t>(range)) return scaled<std::uint16_t>(from, slope, intercept);
            if (fitsIn<std::int32_t>(range)) return scaled<std::int32_t>(from, slope, intercept);
          }
          if constexpr (sizeof(T) == 4) return scaled<double>(from, slope, intercept);
        }
        return scaled<float>(from, slope, intercept);
      },
      values);
}

RawType rawTypeOf(const ImageValues& values) {
  return std::visit(
      [](const auto& v) {
        using T = typename std::decay_t<decltype(v)>::value_type;
        return RawType{int(sizeof(T)), std::is_floating_point_v<T> ? RawType::kFloat
                                       : std::is_signed_v<T>       ? RawType::kSigned
                                                                   : RawType::kUnsigned};
      },
      values);
}

void swapBytes(void* data, size_t count, int bytes) {
  auto* at = static_cast<unsigned char*>(data);
  if (bytes > 1)
    for (size_t i = 0; i < count; ++i, at += bytes) std::reverse(at, at + bytes);
}

}  // namespace slicemorph

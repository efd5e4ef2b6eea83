#include "io/image/raw_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

template <typename From>
ImageValues whole(size_t count, const std::function<void(void*)>& read) {
  std::vector<From> values(count);
  read(values.data());
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const bool fits = count == 0 || (double(*low) >= double(std::numeric_limits<std::int32_t>::min()) &&
                                   double(*high) <= double(std::numeric_limits<std::int32_t>::max()));
  if (fits) return converted<std::int32_t>(values);
  return converted<double>(values);
}

template <typename T>
bool fitsIn(double low, double high) {
  return low >= double(std::numeric_limits<T>::min()) && high <= double(std::numeric_limits<T>::max());
}

template <typename To, typename From>
std::vector<To> scaled(const std::vector<From>& from, double slope, double intercept) {
  std::vector<To> to(from.size());
  std::transform(from.begin(), from.end(), to.begin(),
                 [&](From v) { return To(double(v) * slope + intercept); });
  return to;
}

}  // namespace

ImageValues readValues(RawType type, size_t count, const std::function<void(void*)>& read) {
  if (type.kind == RawType::kFloat)
    return type.bytes == 8 ? direct<double>(count, read) : direct<float>(count, read);
  const bool negative = type.kind == RawType::kSigned;
  switch (type.bytes) {
    case 1:
      if (!negative) return direct<std::uint8_t>(count, read);
      return converted<std::int16_t>(std::get<std::vector<std::int32_t>>(whole<std::int8_t>(count, read)));
    case 2:
      return negative ? direct<std::int16_t>(count, read) : direct<std::uint16_t>(count, read);
    case 4:
      return negative ? direct<std::int32_t>(count, read) : whole<std::uint32_t>(count, read);
    default:
      return negative ? whole<std::int64_t>(count, read) : whole<std::uint64_t>(count, read);
  }
}

ImageValues noValues(RawType type) {
  return readValues(type, 0, [](void*) {});
}

size_t bytesWhileRead(RawType type) {
  const RawType as = rawTypeOf(noValues(type));
  const bool same = as.bytes == type.bytes && as.kind == type.kind;
  return size_t(type.bytes + (same ? 0 : as.bytes));
}

ImageValues rescaled(ImageValues values, double slope, double intercept) {
  if (slope == 1 && intercept == 0) return values;
  return std::visit(
      [&](auto& from) -> ImageValues {
        using T = typename std::decay_t<decltype(from)>::value_type;
        if constexpr (std::is_same_v<T, double>) return scaled<double>(from, slope, intercept);
        if constexpr (std::is_integral_v<T>) {
          if (slope == std::rint(slope) && intercept == std::rint(intercept) && !from.empty()) {
            const auto [least, most] = std::minmax_element(from.begin(), from.end());
            const double a = double(*least) * slope + intercept, b = double(*most) * slope + intercept;
            const double low = std::min(a, b), high = std::max(a, b);
            if (fitsIn<std::int16_t>(low, high)) return scaled<std::int16_t>(from, slope, intercept);
            if (fitsIn<std::uint16_t>(low, high)) return scaled<std::uint16_t>(from, slope, intercept);
            if (fitsIn<std::int32_t>(low, high)) return scaled<std::int32_t>(from, slope, intercept);
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

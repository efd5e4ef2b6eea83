#include "io/image/dicom_rescale.h"

#include "io/image/dicom_decode.h"
#include "io/image/dicom_pixels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

bool isWhole(double v) { return v == std::rint(v); }

/// What the rescaled values of all slices need.
struct ValueRange {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  bool whole = true, wide = false;  ///< only whole numbers; floats would lose digits
};

ValueRange rangeOf(const std::vector<ImageValues>& slices, const std::vector<Rescale>& rescale) {
  std::vector<ValueRange> each(slices.size());
  tbb::parallel_for(size_t(0), slices.size(), [&](size_t i) {
    std::visit(
        [&](const auto& values) {
          using T = typename std::decay_t<decltype(values)>::value_type;
          const Rescale& r = rescale[i];
          ValueRange& range = each[i];
          range.whole = std::is_integral_v<T> && isWhole(r.slope) && isWhole(r.intercept);
          range.wide = std::is_same_v<T, double> || std::is_same_v<T, std::int32_t>;
          if (values.empty()) return;
          const auto [low, high] = std::minmax_element(values.begin(), values.end());
          const double a = double(*low) * r.slope + r.intercept, b = double(*high) * r.slope + r.intercept;
          range.least = std::min(a, b), range.most = std::max(a, b);
        },
        slices[i]);
  });
  ValueRange all;
  for (const ValueRange& r : each) {
    all.least = std::min(all.least, r.least), all.most = std::max(all.most, r.most);
    all.whole = all.whole && r.whole, all.wide = all.wide || r.wide;
  }
  return all;
}

template <typename To>
void convert(std::vector<ImageValues>& slices, const std::vector<Rescale>& rescale) {
  tbb::parallel_for(size_t(0), slices.size(), [&](size_t i) {
    const Rescale r = rescale[i];
    if (std::holds_alternative<std::vector<To>>(slices[i]) && r.slope == 1 && r.intercept == 0) return;
    slices[i] = std::visit(
        [&](const auto& values) -> ImageValues {
          std::vector<To> out(values.size());
          std::transform(values.begin(), values.end(), out.begin(),
                         [&](auto v) { return To(double(v) * r.slope + r.intercept); });
          return out;
        },
        slices[i]);
  });
}

template <typename T>
bool holds(const ValueRange& range) {
  return range.least >= double(std::numeric_limits<T>::min()) &&
         range.most <= double(std::numeric_limits<T>::max());
}

}  // namespace

void rescaleAll(std::vector<ImageValues>& slices, const std::vector<Rescale>& rescale) {
  const bool identity = std::all_of(rescale.begin(), rescale.end(),
                                    [](const Rescale& r) { return r.slope == 1 && r.intercept == 0; });
  const bool oneType = std::all_of(slices.begin(), slices.end(),
                                   [&](const ImageValues& s) { return s.index() == slices[0].index(); });
  if (identity && oneType) return;
  const ValueRange range = rangeOf(slices, rescale);
  if (range.whole && holds<std::int16_t>(range)) return convert<std::int16_t>(slices, rescale);
  if (range.whole && holds<std::uint16_t>(range)) return convert<std::uint16_t>(slices, rescale);
  if (range.whole && holds<std::int32_t>(range)) return convert<std::int32_t>(slices, rescale);
  if (range.wide) return convert<double>(slices, rescale);
  convert<float>(slices, rescale);
}

ImageValues noDicomValues(const DicomSeries& series, const std::vector<DicomSliceRef>& slices) {
  const DicomPixels& pixels = series.files[slices[0].file].pixels;
  const double step = std::ldexp(1, pixels.bitsUsed);
  const double low = pixels.isSigned ? -step / 2 : 0, high = low + step - 1;
  ValueRange range;
  range.wide = pixels.bits > 16;
  bool identity = true;
  for (const DicomSliceRef& r : slices) {
    const DicomFrame& f = series.frameOf(r);
    if (series.files[r.file].table) return std::vector<std::uint16_t>();
    identity = identity && f.slope == 1 && f.intercept == 0;
    range.whole = range.whole && isWhole(f.slope) && isWhole(f.intercept);
    for (const double v : {low, high}) {
      range.least = std::min(range.least, v * f.slope + f.intercept);
      range.most = std::max(range.most, v * f.slope + f.intercept);
    }
  }
  if (identity || pixels.kind != DicomPixels::kWhole) return noValues(layoutOf(pixels).type);
  if (range.whole && holds<std::int16_t>(range)) return std::vector<std::int16_t>();
  if (range.whole && holds<std::uint16_t>(range)) return std::vector<std::uint16_t>();
  if (range.whole && holds<std::int32_t>(range)) return std::vector<std::int32_t>();
  if (range.wide) return std::vector<double>();
  return std::vector<float>();
}

}  // namespace slicemorph

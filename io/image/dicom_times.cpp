#include "io/image/dicom_times.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

namespace slicemorph {
namespace {

/// Times within this share of a step of where even steps have them are even: scanners' clocks round to up to a few
/// hundredths of a second, and steps last about a second.
constexpr double kEven = 0.05;

/// Days from 1970-01-01 to a date of the Gregorian calendar.
double daysTo(int year, int month, int day) {
  // Years that begin in March, so that the leap day is the last of one.
  const int y = month > 2 ? year : year - 1, m = month > 2 ? month - 3 : month + 9;
  return 365.0 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 719469.0;
}

/// The number of `count` digits at a place of a text; -1: there are none.
int digitsAt(const std::string& text, size_t at, size_t count) {
  if (text.size() < at + count) return -1;
  int number = 0;
  for (size_t i = at; i < at + count; ++i) {
    if (!std::isdigit(static_cast<unsigned char>(text[i]))) return -1;
    number = 10 * number + (text[i] - '0');
  }
  return number;
}

/// Seconds of a day: HHMMSS.FFFFFF, or HHMM.
std::optional<double> secondsOfDay(const std::string& text) {
  const int hours = digitsAt(text, 0, 2), minutes = digitsAt(text, 2, 2);
  if (hours < 0 || minutes < 0 || hours > 23 || minutes > 59) return std::nullopt;
  const int whole = digitsAt(text, 4, 2);
  if (whole > 60) return std::nullopt;  // 60: a leap second
  double seconds = std::max(whole, 0);
  if (whole >= 0 && text.size() > 6 && text[6] == '.') seconds += std::strtod(text.c_str() + 6, nullptr);
  return 3600.0 * hours + 60.0 * minutes + seconds;
}

/// When a volume was acquired: with its first slice. None where a slice does not say it.
std::optional<double> timeOf(const DicomSeries& series, const DicomVolume& volume,
                             std::optional<double> DicomTimes::*which) {
  std::optional<double> first;
  for (const DicomSliceRef& r : volume.slices) {
    const std::optional<double>& time = series.frameOf(r).times.*which;
    if (!time) return std::nullopt;
    first = std::min(first.value_or(*time), *time);
  }
  return first;
}

enum class Told { kNot, kUneven, kEven };

/// What volumes' times tell of the step between them. All at once is no time told: some scanners write the start of
/// the series.
std::pair<Told, double> stepBy(const DicomSeries& series, std::optional<double> DicomTimes::*which) {
  std::vector<double> times;
  for (const DicomVolume& volume : series.volumes) {
    const std::optional<double> time = timeOf(series, volume, which);
    if (!time) return {Told::kNot, 0};
    times.push_back(*time);
  }
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  if (*first == *last) return {Told::kNot, 0};
  const double step = (times.back() - times[0]) / double(times.size() - 1);
  for (size_t v = 0; v < times.size(); ++v)
    if (!(std::abs(times[v] - times[0] - double(v) * step) <= kEven * step)) return {Told::kUneven, 0};
  return {Told::kEven, step};
}

/// The repetition time that all slices share; 0: there is none.
double repetitionOf(const DicomSeries& series) {
  const double first = series.frameOf(series.volumes[0].slices[0]).times.repetition;
  for (const DicomVolume& volume : series.volumes)
    for (const DicomSliceRef& r : volume.slices)
      if (series.frameOf(r).times.repetition != first) return 0;
  return first;
}

}  // namespace

std::optional<double> secondsOfDateTime(const std::string& date, const std::string& time) {
  const int year = digitsAt(date, 0, 4), month = digitsAt(date, 4, 2), day = digitsAt(date, 6, 2);
  if (year < 0 || month < 1 || month > 12 || day < 1 || day > 31) return std::nullopt;
  const std::optional<double> seconds = secondsOfDay(time);
  if (!seconds) return std::nullopt;
  return 86400 * daysTo(year, month, day) + *seconds;
}

std::optional<double> secondsOfDateTime(const std::string& text) {
  return secondsOfDateTime(text, text.size() > 8 ? text.substr(8) : "");
}

DicomTimeStep timeStepOf(const DicomSeries& series) {
  if (series.volumes.size() < 2) return {};
  bool positions = true;
  for (const DicomVolume& volume : series.volumes) {
    const bool times =
        volume.marks.size() == 1 &&
        (volume.marks[0] == kTemporal || volume.marks[0] == kTime || volume.marks[0] == kAcquisition);
    if (!times) return {};
    positions = positions && volume.marks[0] == kTemporal;
  }
  for (const auto which : {&DicomTimes::offset, &DicomTimes::acquired}) {
    const auto [told, step] = stepBy(series, which);
    if (told != Told::kNot) return {step, false};
  }
  const double repetition = positions ? repetitionOf(series) : 0;
  return {repetition, repetition > 0};
}

}  // namespace slicemorph

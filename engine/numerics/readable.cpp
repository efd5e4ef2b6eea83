#include "engine/numerics/readable.h"

#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

/// A number below 1000, or one beyond all units, by three digits at most, without zeros at its end: "1.5", "300", "2.62e+58".
std::string threeDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Two units, of which the smaller one is left out where it is none: "3 min 20 s", "2 h".
std::string twoUnits(long large, const char* largeUnit, long small, const char* smallUnit) {
  std::string text = std::to_string(large) + " " + largeUnit;
  if (small > 0) text += " " + std::to_string(small) + " " + smallUnit;
  return text;
}

}  // namespace

std::string readableCount(double count) {
  if (!(std::abs(count) < 1e15)) return threeDigits(count);
  if (!(std::abs(count) < 999999.5)) {
    // What would be rounded to a thousand is one of the next unit.
    const char* const units[] = {"million", "billion", "trillion"};
    size_t unit = 0;
    for (count /= 1e6; std::abs(count) >= 999.5 && unit < 2; ++unit) count /= 1e3;
    char text[48];
    std::snprintf(text, sizeof text, std::abs(count) < 9.95 ? "%.1f" : "%.0f", count);
    std::string number = text;
    if (number.size() > 2 && number.substr(number.size() - 2) == ".0") number.resize(number.size() - 2);
    return number + " " + units[unit];
  }
  std::string digits = std::to_string(std::lround(count));
  if (std::abs(count) >= 9999.5) digits.insert(digits.size() - 3, ",");
  return digits;
}

std::string readableBytes(double bytes) {
  if (!(bytes < 1e21)) return threeDigits(bytes) + " bytes";
  if (bytes < 1023.5)
    return std::to_string(std::lround(bytes)) + (std::lround(bytes) == 1 ? " byte" : " bytes");
  const char* const units[] = {"KB", "MB", "GB", "TB", "PB"};
  size_t unit = 0;
  for (bytes /= 1024; bytes >= 999.5 && unit < 4; ++unit) bytes /= 1024;
  return (bytes >= 999.5 ? std::to_string(std::llround(bytes)) : threeDigits(bytes)) + " " + units[unit];
}

std::string readableDuration(double seconds) {
  char text[32];
  if (seconds < 9.95) {
    std::snprintf(text, sizeof text, "%.1f s", seconds);
    return text;
  }
  const long s = std::lround(seconds), minutes = std::lround(seconds / 60),
             hours = std::lround(seconds / 3600);
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return twoUnits(s / 60, "min", s % 60, "s");
  if (minutes < 24 * 60) return twoUnits(minutes / 60, "h", minutes % 60, "min");
  return twoUnits(hours / 24, hours / 24 == 1 ? "day" : "days", hours % 24, "h");
}

}  // namespace slicemorph

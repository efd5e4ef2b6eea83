#include "tools/job/option_values.h"

#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"
#include "slicemorph/io/output.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <sstream>

namespace slicemorph {

std::string formatNumber(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string formatExactly(double value) {
  for (int digits = 15; digits < 17; ++digits) {
    const std::string text = formatNumber(value, digits);
    if (std::strtod(text.c_str(), nullptr) == value) return text;
  }
  return formatNumber(value, 17);
}

std::vector<std::string> parted(const std::string& text, char mark) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, mark);) parts.push_back(part);
  return parts;
}

std::vector<double> parseNumbers(const std::string& option, const std::string& text) {
  std::vector<double> numbers;
  size_t start = 0;
  while (start <= text.size()) {
    const size_t comma = std::min(text.find(',', start), text.size());
    const std::string part = text.substr(start, comma - start);
    size_t used = 0;
    double number = NAN;
    try {
      number = std::stod(part, &used);
    } catch (const std::exception&) {
    }
    if (used != part.size() || !std::isfinite(number))
      throw InputError(option + " " + text + ": '" + part +
                       "' is not a number; expected numbers separated by commas");
    numbers.push_back(number);
    start = comma + 1;
  }
  return numbers;
}

std::vector<std::string> parseNames(const std::string& option, const std::string& text) {
  std::vector<std::string> names;
  std::istringstream parts(text);
  for (std::string name; std::getline(parts, name, ',');) names.push_back(name);
  if (names.empty() || std::count(names.begin(), names.end(), ""))
    throw InputError(option + " " + text +
                     ": expected names separated by commas, for example density,temperature");
  return names;
}

Vec3d parseDirection(const std::string& option, const std::string& text) {
  const std::string letters = "xyz";
  if (text.size() == 1 && letters.find(text) != std::string::npos) {
    Vec3d axis(0, 0, 0);
    axis[int(letters.find(text))] = 1;
    return axis;
  }
  const std::string expected = "; expected x, y, z or DX,DY,DZ, for example 0,1,0.5";
  std::vector<double> numbers;
  try {
    numbers = parseNumbers(option, text);
  } catch (const InputError&) {
    throw InputError(option + " " + text + " is not a direction" + expected);
  }
  if (numbers.size() != 3) throw InputError(option + " " + text + " has not three numbers" + expected);
  const Vec3d direction(numbers[0], numbers[1], numbers[2]);
  if (direction.length() == 0) throw InputError(option + " " + text + " has no length" + expected);
  return direction;
}

void checkRange(const std::string& option, long value, long low, long high) {
  if (value < low || value > high)
    throw InputError(option + " " + std::to_string(value) + " is out of range; it must be " +
                     std::to_string(low) + " to " + std::to_string(high));
}

void checkPositive(const std::string& option, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(option + " " + formatNumber(value) + " must be a number above 0");
}

void checkInputExists(const std::string& input) { filesOfInput(parseInput(input)); }

void checkOutputPath(const std::string& path) {
  namespace fs = std::filesystem;
  fs::path folder = fs::path(path).parent_path();
  if (folder.empty()) folder = ".";
  std::error_code error;
  if (fs::is_directory(path, error)) throw IoError(path + ": is a folder; the output must be a file");
  if (!fs::exists(folder, error)) throw IoError(path + ": the folder " + folder.string() + " does not exist");
  if (!fs::is_directory(folder, error)) throw IoError(path + ": " + folder.string() + " is not a folder");
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw IoError(path + ": cannot write to the folder " + folder.string() + ": " + std::strerror(errno));
}

void checkExtension(const std::string& path, const std::vector<std::string>& extensions) {
  const std::string extension = OutputName(path).extension();
  if (std::find(extensions.begin(), extensions.end(), extension) != extensions.end()) return;
  std::string known;
  for (const std::string& e : extensions) known += (known.empty() ? "" : " ") + e;
  throw InputError(path + ": cannot write " +
                   (extension.empty() ? "a file without extension" : extension + " files") +
                   " here; expected " + known);
}

}  // namespace slicemorph

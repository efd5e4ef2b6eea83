#include "tools/job/plane_file.h"

#include "io/paths.h"
#include "slicemorph/errors.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace slicemorph {
namespace {

/// Six numbers, the last three no zero vector.
bool toPlane(const std::vector<double>& n, PlaneInSpace& plane) {
  if (n.size() != 6) return false;
  plane = {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
  return plane.normal.length() > 0;
}

/// Numbers up to the first word that is none; `word`: that word.
std::vector<double> numbersOf(std::string line, std::string& word) {
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
  std::istringstream stream(line);
  std::vector<double> numbers;
  while (stream >> word) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (*end != 0 || !std::isfinite(number)) return numbers;
    numbers.push_back(number);
  }
  word.clear();
  return numbers;
}

}  // namespace

PlaneInSpace parsePlane(const std::string& option, const std::string& text) {
  const size_t slash = text.find('/');
  PlaneInSpace plane;
  std::vector<double> numbers;
  if (slash != std::string::npos) {
    numbers = parseNumbers(option, text.substr(0, slash));
    const std::vector<double> normal = parseNumbers(option, text.substr(slash + 1));
    if (numbers.size() != 3) numbers.clear();
    numbers.insert(numbers.end(), normal.begin(), normal.end());
  }
  if (!toPlane(numbers, plane))
    throw InputError(option + " " + text +
                     " is no plane; expected OX,OY,OZ/NX,NY,NZ, a point and a normal that is not zero, for "
                     "example 0,0,1/0,0,1");
  return plane;
}

std::vector<PlaneInSpace> readPlanes(const std::string& path) {
  sizeOfInput(path);
  std::ifstream file(path);
  std::vector<PlaneInSpace> planes;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    line.erase(std::min(line.find('#'), line.size()));
    std::string word;
    const std::vector<double> numbers = numbersOf(line, word);
    const bool heading = planes.empty() && numbers.empty();
    if (heading || line.find_first_not_of(" \t\r") == std::string::npos) continue;
    PlaneInSpace plane;
    if (!word.empty() || !toPlane(numbers, plane))
      throw InputError(path + ":" + std::to_string(number) +
                       ": no plane: expected six numbers, a point and a normal that is not zero: " + line);
    planes.push_back(plane);
  }
  if (planes.empty()) throw InputError(path + " holds no planes; expected ox oy oz nx ny nz on every line");
  return planes;
}

}  // namespace slicemorph

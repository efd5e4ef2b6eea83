#include "tools/job/plane_file.h"

#include "io/paths.h"
#include "slicemorph/errors.h"
#include "tools/job/number_line.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <fstream>
#include <optional>

namespace slicemorph {
namespace {

/// A plane of six numbers, point and normal; none for another number of numbers or a normal of length 0.
std::optional<PlaneInSpace> planeOf(const std::vector<double>& n) {
  if (n.size() != 6) return std::nullopt;
  const PlaneInSpace plane{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
  return plane.normal.length() > 0 ? std::optional(plane) : std::nullopt;
}

}  // namespace

PlaneInSpace parsePlane(const std::string& option, const std::string& text) {
  const size_t slash = text.find('/');
  std::vector<double> numbers;
  if (slash != std::string::npos) {
    numbers = parseNumbers(option, text.substr(0, slash));
    const std::vector<double> normal = parseNumbers(option, text.substr(slash + 1));
    if (numbers.size() != 3) numbers.clear();
    numbers.insert(numbers.end(), normal.begin(), normal.end());
  }
  const std::optional<PlaneInSpace> plane = planeOf(numbers);
  if (!plane)
    throw InputError(option + " " + text +
                     " is no plane; expected OX,OY,OZ/NX,NY,NZ, a point and a normal that is not zero, for "
                     "example 0,0,1/0,0,1");
  return *plane;
}

std::vector<PlaneInSpace> readPlanes(const std::string& path) {
  sizeOfInput(path);
  std::ifstream file(path);
  std::vector<PlaneInSpace> planes;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    line.erase(std::min(line.find('#'), line.size()));
    const NumberLine parts = numberLine(line);
    if (parts.empty() || (planes.empty() && parts.wordFirst)) continue;
    const std::optional<PlaneInSpace> plane = planeOf(parts.numbers);
    if (!parts.words.empty() || !plane)
      throw InputError(path + ":" + std::to_string(number) +
                       ": no plane: expected six numbers, a point and a normal that is not zero: " + line);
    planes.push_back(*plane);
  }
  if (planes.empty()) throw InputError(path + " holds no planes; expected ox oy oz nx ny nz on every line");
  return planes;
}

}  // namespace slicemorph

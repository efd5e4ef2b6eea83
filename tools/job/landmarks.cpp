#include "tools/job/landmarks.h"

#include "io/paths.h"
#include "slicemorph/errors.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace slicemorph {
namespace {

std::vector<std::string> parted(const std::string& text, char mark) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, mark);) parts.push_back(part);
  return parts;
}

Vec3d placeOf(const std::string& option, const std::string& text) {
  const std::vector<double> n = parseNumbers(option, text);
  if (n.size() != 3) throw InputError(option + ": '" + text + "' is no place; expected x,y,z");
  return {n[0], n[1], n[2]};
}

/// The numbers of a line; words are passed over where `words`, else make it no line of numbers.
std::vector<double> numbersOf(const std::string& line, bool words) {
  std::string spaced = line;
  std::replace(spaced.begin(), spaced.end(), ',', ' ');
  std::replace(spaced.begin(), spaced.end(), ';', ' ');
  std::vector<double> numbers;
  std::istringstream stream(spaced);
  for (std::string word; stream >> word;) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (*end == 0 && std::isfinite(number))
      numbers.push_back(number);
    else if (!words)
      return {};
  }
  return numbers;
}

std::vector<Vec3d> readPoints(const std::string& option, const std::string& path) {
  sizeOfInput(path);
  std::ifstream file(path);
  const bool slicer = extensionOf(path) == ".fcsv";
  bool ras = false;
  std::vector<Vec3d> points;
  size_t stated = 0, number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (line.empty() || line[0] == '#') {
      // Slicer's own files are RAS unless they say LPS.
      if (line.find("CoordinateSystem") != std::string::npos)
        ras = line.find("RAS") != std::string::npos || line.find("= 0") != std::string::npos;
      continue;
    }
    if (slicer) {
      const std::vector<std::string> fields = parted(line, ',');
      const std::vector<double> n = fields.size() < 4
                                        ? std::vector<double>()
                                        : numbersOf(fields[1] + "," + fields[2] + "," + fields[3], false);
      if (n.size() != 3)
        throw InputError(option + ": " + path + ":" + std::to_string(number) + ": no point: " + line);
      points.emplace_back(n[0], n[1], n[2]);
      continue;
    }
    const std::vector<double> n = numbersOf(line, true);
    if (points.empty() && (line == "point" || n.empty())) continue;  // a header
    if (line == "index")
      throw InputError(option + ": " + path + " holds voxel indices; give points in world units");
    if (points.empty() && n.size() == 1 && stated == 0) {
      stated = size_t(n[0]);
    } else if (n.size() == 3) {
      points.emplace_back(n[0], n[1], n[2]);
    } else {
      throw InputError(option + ": " + path + ":" + std::to_string(number) + ": expected x y z, not '" +
                       line + "'");
    }
  }
  if (points.empty()) throw InputError(option + ": " + path + " holds no points");
  if (stated != 0 && stated != points.size())
    throw InputError(option + ": " + path + " states " + std::to_string(stated) + " points and holds " +
                     std::to_string(points.size()));
  if (ras)
    for (Vec3d& p : points) p[0] = -p[0], p[1] = -p[1];
  return points;
}

}  // namespace

std::vector<Feature> featuresOf(const std::vector<Landmark>& landmarks) {
  std::vector<Feature> features;
  for (const Landmark& landmark : landmarks) {
    Feature feature;
    feature.name = "landmark " + std::to_string(features.size() + 1);
    for (const Vec3d& place : landmark) feature.places.push_back({place});
    features.push_back(feature);
  }
  return features;
}

std::vector<Landmark> readLandmarks(const std::string& option, const std::string& text, size_t inputs) {
  std::vector<Landmark> landmarks;
  if (text.empty()) return landmarks;
  if (text.find('=') != std::string::npos) {
    for (const std::string& mark : parted(text, ';')) {
      landmarks.emplace_back();
      for (const std::string& place : parted(mark, '=')) landmarks.back().push_back(placeOf(option, place));
      if (landmarks.back().size() != inputs)
        throw InputError(option + ": a landmark has " + std::to_string(landmarks.back().size()) +
                         " places for " + std::to_string(inputs) + " inputs: " + mark);
    }
    return landmarks;
  }
  const std::vector<std::string> files = parted(text, ',');
  if (files.size() != inputs)
    throw InputError(option + " " + text + ": " + std::to_string(files.size()) + " files of points for " +
                     std::to_string(inputs) + " inputs; give one per input");
  for (size_t k = 0; k < files.size(); ++k) {
    const std::vector<Vec3d> points = readPoints(option, files[k]);
    if (k == 0) landmarks.resize(points.size());
    if (points.size() != landmarks.size())
      throw InputError(option + ": " + files[k] + " holds " + std::to_string(points.size()) + " points, " +
                       files[0] + " " + std::to_string(landmarks.size()) +
                       "; the n-th of one belongs with the n-th of the others");
    for (size_t i = 0; i < points.size(); ++i) landmarks[i].push_back(points[i]);
  }
  return landmarks;
}

}  // namespace slicemorph

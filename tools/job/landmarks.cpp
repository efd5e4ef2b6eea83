#include "tools/job/landmarks.h"

#include "io/paths.h"
#include "slicemorph/errors.h"
#include "tools/job/number_line.h"
#include "tools/job/option_values.h"

#include <fstream>
#include <optional>
#include <sstream>

namespace slicemorph {
namespace {

Vec3d parsePosition(const std::string& option, const std::string& text) {
  const std::vector<double> n = parseNumbers(option, text);
  if (n.size() != 3) throw InputError(option + ": '" + text + "' is no place; expected x,y,z");
  return {n[0], n[1], n[2]};
}

/// The coordinates in a line of 3D Slicer's .fcsv: the second to fourth field; none where these
/// are no numbers.
std::optional<Vec3d> slicerPoint(const std::string& line) {
  const std::vector<std::string> fields = parted(line, ',');
  if (fields.size() < 4) return std::nullopt;
  const NumberLine parts = numberLine(fields[1] + "," + fields[2] + "," + fields[3]);
  if (!parts.words.empty() || parts.numbers.size() != 3) return std::nullopt;
  return Vec3d(parts.numbers[0], parts.numbers[1], parts.numbers[2]);
}

/// Whether a "CoordinateSystem" comment says RAS, by name or, in older versions of Slicer, as 0.
bool saysRas(const std::string& comment) {
  return comment.find("RAS") != std::string::npos || comment.find("= 0") != std::string::npos;
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
      if (line.find("CoordinateSystem") != std::string::npos) ras = saysRas(line);
      continue;
    }
    const std::string where = option + ": " + path + ":" + std::to_string(number) + ": ";
    if (slicer) {
      const std::optional<Vec3d> point = slicerPoint(line);
      if (!point) throw InputError(where + "no point: " + line);
      points.push_back(*point);
      continue;
    }
    const std::vector<double> n = numberLine(line).numbers;
    if (points.empty() && n.empty() && line != "index") continue;  // a header
    if (line == "index")
      throw InputError(option + ": " + path + " holds voxel indices; give points in world units");
    if (points.empty() && n.size() == 1 && stated == 0)
      stated = size_t(n[0]);
    else if (n.size() == 3)
      points.emplace_back(n[0], n[1], n[2]);
    else
      throw InputError(where + "expected x y z, not '" + line + "'");
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
    for (const Vec3d& position : landmark) feature.positions.push_back({position});
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
      for (const std::string& position : parted(mark, '='))
        landmarks.back().push_back(parsePosition(option, position));
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

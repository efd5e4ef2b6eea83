#include "tools/job/landmarks.h"

#include "io/points/position_file.h"
#include "slicemorph/errors.h"
#include "tools/job/option_values.h"

namespace slicemorph {
namespace {

Vec3d parsePosition(const std::string& option, const std::string& text) {
  const std::vector<double> n = parseNumbers(option, text);
  if (n.size() != 3) throw InputError(option + ": '" + text + "' is no place; expected x,y,z");
  return {n[0], n[1], n[2]};
}

std::vector<Vec3d> readPoints(const std::string& option, const std::string& path) {
  try {
    return PositionFile(path).positions();
  } catch (const InputError& error) {
    throw InputError(option + ": " + error.what());
  } catch (const IoError& error) {
    throw IoError(option + ": " + error.what());
  }
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

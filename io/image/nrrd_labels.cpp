#include "io/image/nrrd_labels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace slicemorph {
namespace {

/// A value of a key without what NRRD puts before backslashes and line ends.
std::string unescaped(const std::string& value) {
  std::string text;
  for (size_t i = 0; i < value.size(); ++i) {
    if (value[i] == '\\' && i + 1 < value.size())
      ++i, text += value[i] == 'n' ? ' ' : value[i];
    else
      text += value[i];
  }
  return text;
}

std::optional<std::array<std::uint8_t, 3>> colorOf(const std::string& text) {
  std::istringstream in(text);
  std::array<std::uint8_t, 3> color{};
  for (std::uint8_t& c : color) {
    double share = 0;
    if (!(in >> share) || !(share >= 0 && share <= 1)) return std::nullopt;
    c = std::uint8_t(std::lround(share * 255));
  }
  return color;
}

}  // namespace

std::vector<LabelName> labelsOfNrrd(const std::map<std::string, std::string>& keys, int layer) {
  std::vector<LabelName> labels;
  for (int n = 0;; ++n) {
    const std::string key = "Segment" + std::to_string(n) + "_";
    const auto value = [&](const char* name) {
      const auto at = keys.find(key + name);
      return at == keys.end() ? std::string() : at->second;
    };
    if (!keys.count(key + "ID") && !keys.count(key + "Name")) return labels;
    // Slicer's older files have neither: each segment is a layer of its own, with the label 1. A label without a layer is
    // one of the only layer.
    const std::string number = value("LabelValue"), place = value("Layer");
    const int label = number.empty() ? 1 : std::atoi(number.c_str());
    if ((!place.empty() ? std::atoi(place.c_str()) : number.empty() ? n : 0) != layer || label <= 0) continue;
    labels.push_back({label, unescaped(value("Name")), colorOf(value("Color"))});
  }
}

}  // namespace slicemorph

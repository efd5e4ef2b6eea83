#include "io/image/dicom_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

constexpr double kSkewed = 5e-3;   // directions in files have three decimals or more
constexpr double kFarthest = 1e9;  // millimetres; what damaged positions and sizes of pixels are beyond

}  // namespace

std::optional<std::array<Vec3d, 2>> dicomAxes(const std::vector<double>& orientation) {
  const std::vector<double>& v = orientation;
  if (v.size() != 6) return std::nullopt;
  const Vec3d x(v[0], v[1], v[2]), y(v[3], v[4], v[5]);
  const bool right = std::abs(x.length() - 1) < kSkewed && std::abs(y.length() - 1) < kSkewed &&
                     std::abs(x.dot(y)) < kSkewed;
  if (!right) return std::nullopt;
  return std::array<Vec3d, 2>{x, y};
}

std::optional<std::array<Vec3d, 2>> nearestAxes(const std::vector<double>& orientation) {
  constexpr double kFlat =
      0.1;  // sine of the angle between rows and columns: 6 degrees, far from any image's
  const std::vector<double>& v = orientation;
  if (v.size() != 6) return std::nullopt;
  Vec3d x(v[0], v[1], v[2]), y(v[3], v[4], v[5]);
  if (!(x.length() > 0 && y.length() > 0) || !std::isfinite(x.length() + y.length())) return std::nullopt;
  x.normalize(), y.normalize();
  if (x.cross(y).length() < kFlat) return std::nullopt;
  // Both turned alike until they are at right angles.
  const Vec3d middle = (x + y).unit(), across = (x - y).unit();
  return std::array<Vec3d, 2>{(middle + across).unit(), (middle - across).unit()};
}

std::optional<Vec3d> dicomPlace(const std::vector<double>& position) {
  const bool inReach =
      std::all_of(position.begin(), position.end(), [](double along) { return std::abs(along) < kFarthest; });
  if (position.size() != 3 || !inReach) return std::nullopt;
  return Vec3d(position[0], position[1], position[2]);
}

std::optional<std::array<double, 2>> dicomPixel(const std::vector<double>& spacing) {
  const auto isSize = [](double pixel) { return pixel > 1 / kFarthest && pixel < kFarthest; };
  if (spacing.size() != 2 || !isSize(spacing[0]) || !isSize(spacing[1])) return std::nullopt;
  return std::array<double, 2>{spacing[1], spacing[0]};  // the file has the distance between rows first
}

std::string shortText(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", value);
  return digits;
}

}  // namespace slicemorph

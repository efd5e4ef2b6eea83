#include "io/image/dicom_color.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

// sRGB to XYZ adapted to D50 (IEC 61966-2-1, Bradford), back, and the white point.
constexpr double kToXyz[3][3] = {
    {0.4360747, 0.3850649, 0.1430804}, {0.2225045, 0.7168786, 0.0606169}, {0.0139322, 0.0971045, 0.7141733}};
constexpr double kFromXyz[3][3] = {{3.1338561, -1.6168667, -0.4906146},
                                   {-0.9787684, 1.9161415, 0.0334540},
                                   {0.0719453, -0.2289914, 1.4052427}};
constexpr double kWhite[3] = {0.9642, 1, 0.8249};
// Of CIE L*a*b* (CIE 15): below the first, and the slope there.
constexpr double kDark = 216.0 / 24389, kSlope = 24389.0 / 27;
constexpr double kMostStored = 65535;

double clamped(double share) { return std::min(std::max(share, 0.0), 1.0); }

}  // namespace

std::vector<std::uint16_t> dicomLabOf(const std::array<std::uint8_t, 3>& color) {
  double linear[3], f[3];
  for (int c = 0; c < 3; ++c) {
    const double share = color[size_t(c)] / 255.0;
    linear[c] = share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
  }
  for (int r = 0; r < 3; ++r) {
    double t = 0;
    for (int c = 0; c < 3; ++c) t += kToXyz[r][c] * linear[c];
    t /= kWhite[r];
    f[r] = t > kDark ? std::cbrt(t) : (kSlope * t + 16) / 116;
  }
  const auto stored = [](double share) { return std::uint16_t(std::lround(clamped(share) * kMostStored)); };
  return {stored((116 * f[1] - 16) / 100), stored((500 * (f[0] - f[1]) + 128) / 255),
          stored((200 * (f[1] - f[2]) + 128) / 255)};
}

std::array<std::uint8_t, 3> colorOfDicomLab(const std::vector<double>& stored) {
  const double l = stored[0] / kMostStored * 100, a = stored[1] / kMostStored * 255 - 128,
               b = stored[2] / kMostStored * 255 - 128;
  const double y = (l + 16) / 116, f[3] = {y + a / 500, y, y - b / 200};
  double xyz[3];
  for (int r = 0; r < 3; ++r) {
    const double cube = f[r] * f[r] * f[r];
    xyz[r] = kWhite[r] * (cube > kDark ? cube : (116 * f[r] - 16) / kSlope);
  }
  std::array<std::uint8_t, 3> color{};
  for (size_t c = 0; c < 3; ++c) {
    double linear = 0;
    for (int r = 0; r < 3; ++r) linear += kFromXyz[c][r] * xyz[r];
    linear = clamped(linear);
    const double share = linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    color[c] = std::uint8_t(std::lround(clamped(share) * 255));
  }
  return color;
}

}  // namespace slicemorph

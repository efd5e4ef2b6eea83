#include "engine/render/black_body.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// An asymmetric Gaussian, with a different width on each side.
double bell(double x, double mean, double left, double right) {
  const double t = (x - mean) / (x < mean ? left : right);
  return std::exp(-0.5 * t * t);
}

/// X, Y, Z of a wavelength in nanometres; the constants are those of [WSS13].
Vec3d observed(double nm) {
  return {1.056 * bell(nm, 599.8, 37.9, 31.0) + 0.362 * bell(nm, 442.0, 16.0, 26.7) -
              0.065 * bell(nm, 501.1, 20.4, 26.2),
          0.821 * bell(nm, 568.8, 46.9, 40.5) + 0.286 * bell(nm, 530.9, 16.3, 31.1),
          1.217 * bell(nm, 437.0, 11.8, 36.0) + 0.681 * bell(nm, 459.0, 26.0, 13.8)};
}

/// Planck's law relative to 560 nm, which keeps the values of cold bodies in range.
double planck(double nm, double kelvin) {
  constexpr double kSecond = 1.438776877e7;  // second radiation constant h c / k, nanometre kelvins
  const double exponent = kSecond / kelvin * (1 / nm - 1 / 560.0);
  const double bose = (1 - std::exp(-kSecond / (560.0 * kelvin))) / (1 - std::exp(-kSecond / (nm * kelvin)));
  return std::pow(560 / nm, 5) * std::exp(-exponent) * bose;
}

}  // namespace

Colour blackBody(double kelvin) {
  Vec3d xyz(0.0);
  for (double nm = 380; nm <= 780; nm += 5) xyz += observed(nm) * planck(nm, kelvin);
  xyz /= xyz.y();
  const Vec3d rgb(3.2404542 * xyz.x() - 1.5371385 * xyz.y() - 0.4985314 * xyz.z(),
                  -0.9692660 * xyz.x() + 1.8760108 * xyz.y() + 0.0415560 * xyz.z(),
                  0.0556434 * xyz.x() - 0.2040259 * xyz.y() + 1.0572252 * xyz.z());
  return Colour(float(std::max(0.0, rgb.x())), float(std::max(0.0, rgb.y())), float(std::max(0.0, rgb.z())));
}

}  // namespace slicemorph

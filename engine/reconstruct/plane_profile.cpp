#include "engine/reconstruct/plane_profile.h"

#include "engine/numerics/conjugate_gradients.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace slicemorph {

namespace {

constexpr double kHeldPixels = 1.5;  // on both sides of a contour: fixes value and slope
constexpr int kIterations = 80;      // at most
constexpr double kEnough = 1e-6;     // of the squared residual, relative to the initial one

/// The biharmonic operator in the plane (13-point stencil), at the pixels that are not fixed.
class ProfileSystem {
 public:
  ProfileSystem(const PlaneImage& image, double reach) : width_(image.width) {
    for (int j = 2; j < image.height - 2; ++j)
      for (int i = 2; i < image.width - 2; ++i) {
        const size_t n = size_t(j) * image.width + i;
        const double d = std::abs(image.distance[n]);
        if (d > kHeldPixels * image.pixel && d < reach) active_.push_back(std::uint32_t(n));
      }
  }

  size_t size() const { return active_.size(); }
  size_t node(size_t i) const { return active_[i]; }
  float diagonal(size_t) const { return 1; }
  /// Serial: planes are solved in parallel, each by one task.
  Grain grain() const { return {std::numeric_limits<size_t>::max()}; }

  void apply(const std::vector<float>& values, std::vector<float>& product) const {
    const int w = width_;
    for (size_t k = 0; k < active_.size(); ++k) {
      const float* v = &values[active_[k]];
      product[k] = 20 * v[0] - 8 * (v[-1] + v[1] + v[-w] + v[w]) +
                   2 * (v[-w - 1] + v[-w + 1] + v[w - 1] + v[w + 1]) + v[-2] + v[2] + v[-2 * w] + v[2 * w];
    }
  }

 private:
  int width_;
  std::vector<std::uint32_t> active_;
};

}  // namespace

std::vector<float> planeProfile(const PlaneImage& image, const std::vector<float>& slopes, double reach) {
  std::vector<float> values(image.distance.size());
  for (size_t n = 0; n < values.size(); ++n) values[n] = image.distance[n] * slopes[image.nearest[n]];
  ProfileSystem system(image, reach);
  std::vector<float> residual(system.size());
  system.apply(values, residual);
  for (float& r : residual) r = -r;
  conjugateGradients(system, {kIterations, kEnough}, std::move(residual), values);
  return values;
}

}  // namespace slicemorph

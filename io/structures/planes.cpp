#include "slicemorph/io/structure_file.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

std::vector<ImagePlane> planesOf(const ImageLattice& lattice) {
  std::vector<ImagePlane> planes;
  for (int k = 0; k < lattice.size[2]; ++k) {
    ImagePlane plane;
    plane.origin = lattice.toWorld(Vec3d(0, 0, k));
    for (int d = 0; d < 2; ++d) plane.step[d] = lattice.step[d], plane.size[d] = lattice.size[d];
    planes.push_back(plane);
  }
  if (!planes.empty() && planes[0].normal().dot(lattice.step[2]) < 0)
    std::reverse(planes.begin(), planes.end());
  return planes;
}

double gapOf(const std::vector<ImagePlane>& planes) {
  if (planes.size() < 2) return 1;
  std::vector<double> gaps;
  const Vec3d normal = planes[0].normal();
  for (size_t p = 1; p < planes.size(); ++p)
    gaps.push_back(std::abs((planes[p].origin - planes[p - 1].origin).dot(normal)));
  std::nth_element(gaps.begin(), gaps.begin() + long(gaps.size() / 2), gaps.end());
  return gaps[gaps.size() / 2];
}

std::array<std::uint8_t, 3> colorOfStructure(int number) {
  // Hues a golden section of the circle apart, of saturation .65 and value .9.
  const double turn = number * 0.61803398874989485, hue = 6 * (turn - std::floor(turn));
  std::array<std::uint8_t, 3> color;
  for (int c = 0; c < 3; ++c) {
    const double k = std::fmod((c == 0 ? 5 : c == 1 ? 3 : 1) + hue, 6);
    color[size_t(c)] =
        std::uint8_t(std::lround(255 * 0.9 * (1 - 0.65 * std::clamp(std::min(k, 4 - k), 0.0, 1.0))));
  }
  return color;
}

}  // namespace slicemorph

#include "engine/numerics/distance_transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

size_t indexIn(const openvdb::Coord& size, int i, int j, int k) {
  return (size_t(k) * size_t(size[1]) + size_t(j)) * size_t(size[0]) + size_t(i);
}

/// Reference: the nearest voxel of the other kind, by trying all.
double nearestOfOtherKind(const std::vector<char>& inside, const openvdb::Coord& size, const Vec3d& spacing,
                          int i, int j, int k) {
  const char kind = inside[indexIn(size, i, j, k)];
  double least = 1e30;
  for (int c = 0; c < size[2]; ++c)
    for (int b = 0; b < size[1]; ++b)
      for (int a = 0; a < size[0]; ++a)
        if (inside[indexIn(size, a, b, c)] != kind)
          least = std::min(least, (spacing * Vec3d(a - i, b - j, c - k)).lengthSqr());
  return std::sqrt(least);
}

/// Few inside voxels (far from each other), half of all, and nearly all; a different spacing along each axis.
TEST(DistanceTransform, AgreesWithLookingAtAllVoxels) {
  const openvdb::Coord size(9, 7, 6);
  const Vec3d spacing(0.7, 1.3, 2.1);
  std::mt19937 random(5);
  for (double share : {0.02, 0.5, 0.97}) {
    std::vector<char> inside(size_t(size[0]) * size[1] * size[2]);
    for (char& v : inside) v = std::uniform_real_distribution<>(0, 1)(random) < share;
    inside[11] = 1, inside[12] = 0;
    const std::vector<float> distances = signedDistances(inside, size, spacing);
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i) {
          const size_t n = indexIn(size, i, j, k);
          const double d = nearestOfOtherKind(inside, size, spacing, i, j, k);
          // Squares are stored in single precision.
          ASSERT_NEAR(distances[n], inside[n] ? d : -d, 1e-5 * d)
              << share << " " << i << " " << j << " " << k;
        }
  }
}

}  // namespace
}  // namespace slicemorph

#include "engine/numerics/lattice_field.h"
#include "tests/support/lattice_points.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

const Lattice kLattice{{-1.2, 0.4, 2}, 0.25, {9, 8, 7}};

/// Trilinear functions (products of one linear function per axis) are reproduced exactly.
Vec3d trilinear(const Vec3d& p) {
  return {1 + p[0] * p[1] * p[2], 2 - p[0] * p[1] + p[2], p[1] * p[2] - 3 * p[0]};
}

TEST(Lattice, CoversItsBoxCentred) {
  const openvdb::BBoxd box(Vec3d(-1, 2, 0), Vec3d(1.1, 2.3, 5));
  const Lattice lattice = Lattice::over(box, 0.3);
  const openvdb::Coord end = lattice.size - openvdb::Coord(1);
  const Vec3d last = lattice.position(end[0], end[1], end[2]);
  for (int a = 0; a < 3; ++a) {
    EXPECT_LE(lattice.origin[a], box.min()[a] + 1e-9);
    EXPECT_GE(last[a], box.max()[a] - 1e-9);
    EXPECT_LT(last[a] - lattice.origin[a], box.extents()[a] + lattice.spacing);
    EXPECT_NEAR(lattice.origin[a] + last[a], box.min()[a] + box.max()[a], 1e-12);
  }
  EXPECT_EQ(lattice.size[0], 8);  // 2.1 is seven spacings: eight nodes
}

TEST(LatticeField, SamplesTrilinearFunctionsExactly) {
  const VectorField field = sampled(kLattice, trilinear);
  for (const Vec3d& p : pointsIn(kLattice, 200)) {
    EXPECT_LE((sampleField(kLattice, field, p) - trilinear(p)).length(), 1e-5) << p;
    EXPECT_EQ(sampleField(kLattice, field, p), sampleContinued(kLattice, field, p));
  }
}

TEST(LatticeField, EndsInNothingOrGoesOn) {
  const VectorField field = sampled(kLattice, trilinear);
  const Vec3d last = kLattice.position(8, 7, 6);
  for (const Vec3d& p : pointsIn(kLattice, 200, 0.6)) {
    Vec3d nearest = p;
    for (int a = 0; a < 3; ++a) nearest[a] = std::min(std::max(p[a], kLattice.origin[a]), last[a]);
    EXPECT_LE((sampleContinued(kLattice, field, p) - trilinear(nearest)).length(), 1e-5) << p;
    if (nearest != p) {
      EXPECT_EQ(sampleField(kLattice, field, p), Vec3d(0.0)) << p;
    }
  }
}

/// Catmull-Rom splines reproduce products of parabolas; near the border the zeros beyond it contribute.
TEST(LatticeField, ResamplesParabolasExactly) {
  const auto f = [](const Vec3d& p) {
    return Vec3d(p[0] * p[0] - p[1], p[1] * p[1] * p[2], 1 + p[2] * p[2] * p[0] * p[0]);
  };
  const Lattice fine{kLattice.position(1, 1, 1) + Vec3d(0.003), 0.11, {12, 10, 8}};
  const VectorField resampled = resampleField(kLattice, sampled(kLattice, f), fine);
  const openvdb::Coord end = fine.size - openvdb::Coord(1);
  for (int a = 0; a < 3; ++a)
    ASSERT_LE(fine.position(end[0], end[1], end[2])[a], kLattice.position(7, 6, 5)[a]);
  for (int z = 0; z < fine.size[2]; ++z)
    for (int y = 0; y < fine.size[1]; ++y)
      for (int x = 0; x < fine.size[0]; ++x)
        ASSERT_LE((Vec3d(resampled[fine.index(x, y, z)]) - f(fine.position(x, y, z))).length(), 2e-5);
  const VectorField same = resampleField(kLattice, sampled(kLattice, f), kLattice);
  for (size_t i = 0; i < same.size(); ++i) ASSERT_LE((same[i] - sampled(kLattice, f)[i]).length(), 1e-6f);
}

}  // namespace
}  // namespace slicemorph

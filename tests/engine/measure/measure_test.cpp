// Measures against closed forms. A surface of curvature radius R on a grid of spacing h has an error of h^2 /
// R, from which the tolerances are derived.
#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <gtest/gtest.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <cmath>
#include <functional>
#include <random>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
using Distance = std::function<double(const Vec3d&)>;

Distance sphere(const Vec3d& centre, double radius) {
  return [=](const Vec3d& p) { return (p - centre).length() - radius; };
}

Distance torus(const Vec3d& centre, double ring, double tube) {
  return [=](const Vec3d& p) {
    const Vec3d q = p - centre;
    return std::hypot(std::hypot(q[0], q[1]) - ring, q[2]) - tube;
  };
}

Distance either(Distance a, Distance b) {
  return [=](const Vec3d& p) { return std::min(a(p), b(p)); };
}

Distance without(Distance a, Distance b) {
  return [=](const Vec3d& p) { return std::max(a(p), -b(p)); };
}

/// Level set of a distance function in the cube [-half, half]^3.
FloatGrid::Ptr levelSet(const Distance& distance, double h, double half) {
  const float band = float(kHalfWidth * h);
  auto grid = FloatGrid::create(band);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto accessor = grid->getAccessor();
  const int n = int(half / h);
  for (int x = -n; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z) {
        const double d = distance(h * Vec3d(x, y, z));
        if (std::abs(d) < band) accessor.setValue({x, y, z}, float(d));
      }
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

/// Axis-aligned box as a mesh; if `outwards` is false it is a cavity.
void addBox(Mesh& mesh, const Vec3d& low, const Vec3d& high, bool outwards = true) {
  const auto base = openvdb::Index32(mesh.points.size());
  for (int i = 0; i < 8; ++i)
    mesh.points.emplace_back(i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]);
  const openvdb::Index32 quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads)
    for (int half = 0; half < 2; ++half) {
      openvdb::Vec3I t(base + q[0], base + q[1 + half], base + q[2 + half]);
      if (!outwards) std::swap(t[1], t[2]);
      mesh.triangles.push_back(t);
    }
}

TEST(MeasureMesh, BoxIsExact) {
  Mesh mesh;
  addBox(mesh, {1000, 0, 0}, {1001, 2, 3});
  const ShapeMeasures m = measureMesh(mesh);
  EXPECT_NEAR(m.volume, 6, 1e-12);
  EXPECT_NEAR(m.area, 22, 1e-12);
  EXPECT_EQ(m.pieces, 1);
  EXPECT_EQ(m.genus, 0);
}

TEST(MeasureMesh, NestedShells) {
  Mesh mesh;
  addBox(mesh, {0, 0, 0}, {10, 10, 10});
  addBox(mesh, {1, 1, 1}, {9, 9, 9}, false);
  EXPECT_EQ(measureMesh(mesh).pieces, 1) << "a hollow box is one piece";
  addBox(mesh, {2, 2, 2}, {8, 8, 8});
  const ShapeMeasures m = measureMesh(mesh);
  EXPECT_EQ(m.pieces, 2) << "a box within a hollow box";
  EXPECT_EQ(m.genus, 0);
  EXPECT_NEAR(m.volume, 1000 - 512 + 216, 1e-9);
}

TEST(MeasureMesh, ShellsThatTouchAtAPointStayApart) {
  Mesh point;
  addBox(point, {0, 0, 0}, {1, 1, 1});
  addBox(point, {1, 1, 1}, {2, 2, 2});
  for (auto& t : point.triangles)
    for (int i = 0; i < 3; ++i)
      if (t[i] == 8) t[i] = 7;  // the corner (1, 1, 1) of both
  const ShapeMeasures m = measureMesh(point);
  EXPECT_EQ(m.pieces, 2);
  EXPECT_EQ(m.genus, 0);
}

TEST(MeasureMesh, EmptyIsNothing) {
  const ShapeMeasures m = measureMesh({});
  EXPECT_EQ(m.pieces, 0);
  EXPECT_EQ(m.volume, 0);
}

TEST(MeasureShape, SphereAndTorus) {
  const double h = 1.0 / 32;
  const ShapeMeasures s = measureShape(*levelSet(sphere({0.1, 0, 0}, 1), h, 1.3));
  // Vertices are means of points on the edges of a cell, at most h / sqrt 2 away along the surface: h^2 / 4 R
  // too deep. Facets of side h are another h^2 / 6 R deeper in the mean. An error of e changes the volume by
  // area times e.
  const double e = h * h * 5 / 12;
  EXPECT_NEAR(s.volume, 4 * kPi / 3, 4 * kPi * e);
  EXPECT_NEAR(s.area, 4 * kPi, 4 * kPi * 4 * e);
  EXPECT_EQ(s.pieces, 1);
  EXPECT_EQ(s.genus, 0);
  const ShapeMeasures t = measureShape(*levelSet(torus({0, 0.05, 0}, 1, 0.3), h, 1.5));
  const double area = 4 * kPi * kPi * 0.3;
  EXPECT_NEAR(t.volume, 2 * kPi * kPi * 0.09, area * e / 0.3);
  EXPECT_EQ(t.pieces, 1);
  EXPECT_EQ(t.genus, 1);
}

TEST(MeasureShape, PiecesAndGenusAddUp) {
  const double h = 1.0 / 16;
  const auto twoTori = either(torus({-2, 0, 0}, 1, 0.3), torus({2, 0, 0}, 1, 0.3));
  const ShapeMeasures two = measureShape(*levelSet(twoTori, h, 3.6));
  EXPECT_EQ(two.pieces, 2);
  EXPECT_EQ(two.genus, 2);
  const auto eight = either(torus({-0.6, 0, 0}, 1, 0.2), torus({0.6, 0, 0}, 1, 0.2));
  const ShapeMeasures joined = measureShape(*levelSet(eight, h, 2.6));
  EXPECT_EQ(joined.pieces, 1);
  EXPECT_EQ(joined.genus, 3) << "two rings that cross each other twice enclose three holes";
  const auto hollow = without(sphere({0, 0, 0}, 1), torus({0, 0, 0}, 0.5, 0.2));
  const ShapeMeasures cavity = measureShape(*levelSet(hollow, h, 1.3));
  EXPECT_EQ(cavity.pieces, 1);
  EXPECT_EQ(cavity.genus, 1) << "the wall of the cavity is a torus";
}

TEST(SurfaceDistance, ConcentricSpheresAndMovedBox) {
  const double h = 1.0 / 32;
  const Mesh a = surfaceOf(*levelSet(sphere({0, 0, 0}, 1), h, 1.2));
  const Mesh b = surfaceOf(*levelSet(sphere({0, 0, 0}, 0.75), h, 1.2));
  const SurfaceDistance d = surfaceDistance(a, b);
  EXPECT_NEAR(d.mean, 0.25, h * h);
  EXPECT_NEAR(d.max, 0.25, h * h);
  Mesh box, moved;
  addBox(box, {0, 0, 0}, {1, 1, 1});
  addBox(moved, {3, 4, 0}, {4, 5, 1});
  EXPECT_DOUBLE_EQ(surfaceDistance(box, moved).max, std::hypot(3.0, 4.0));
  EXPECT_DOUBLE_EQ(surfaceDistance(box, box).max, 0);
  EXPECT_THROW(surfaceDistance(box, Mesh{}), GeometryError);
}

/// From near its centre all of a large sphere is nearly as far: without bounds along the normals this takes minutes.
TEST(SurfaceDistance, OfASphereInAMuchLargerOne) {
  const double large = 2000;
  const auto ball = [](double radius, int rings) {
    Mesh mesh;
    for (int i = 0; i <= rings; ++i)
      for (int j = 0; j < 2 * rings; ++j) {
        const double down = kPi * i / rings, round = kPi * j / rings;
        mesh.points.emplace_back(radius * std::sin(down) * std::cos(round),
                                 radius * std::sin(down) * std::sin(round), radius * std::cos(down));
      }
    const auto at = [&](int i, int j) { return openvdb::Index32(i * 2 * rings + j % (2 * rings)); };
    for (int i = 0; i < rings; ++i)
      for (int j = 0; j < 2 * rings; ++j) {
        mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
        mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
      }
    return mesh;
  };
  const int rings = 150;
  const Mesh small = ball(1, 20), around = ball(large, rings);
  const SurfaceDistance d = distanceTo(small.points, around);
  // The large mesh is inscribed: no place of it is deeper than a cell's diagonal is long, half of it each way.
  const double sagitta = large * (1 - std::cos(kPi / rings / std::sqrt(2.0)));
  EXPECT_NEAR(d.mean, large - 1, sagitta);
  EXPECT_LE(d.max, large - 1 + 1e-3) << "single precision at this size";
}

TEST(SurfaceDistance, AgreesWithBruteForce) {
  // Reference: the distance of a point to a triangle by a dense scan of its barycentric coordinates.
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto soup = [&](int triangles) {
    Mesh mesh;
    for (int i = 0; i < 3 * triangles; ++i)
      mesh.points.emplace_back(unit(random), unit(random), unit(random));
    for (int i = 0; i < triangles; ++i) mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    return mesh;
  };
  const int steps = 300;
  const auto scan = [&](const Vec3d& p, const Mesh& mesh) {
    double best = 1e9;
    for (const auto& t : mesh.triangles) {
      const Vec3d a(mesh.points[t[0]]), b(mesh.points[t[1]]), c(mesh.points[t[2]]);
      for (int i = 0; i <= steps; ++i)
        for (int j = 0; i + j <= steps; ++j)
          best = std::min(best,
                          (a + (b - a) * (double(i) / steps) + (c - a) * (double(j) / steps) - p).length());
    }
    return best;
  };
  const Mesh a = soup(9), b = soup(7);
  double largest = 0, sum = 0;
  for (const auto& p : a.points) largest = std::max(largest, scan(Vec3d(p), b)), sum += scan(Vec3d(p), b);
  for (const auto& p : b.points) largest = std::max(largest, scan(Vec3d(p), a)), sum += scan(Vec3d(p), a);
  const SurfaceDistance d = surfaceDistance(a, b);
  // The scan misses the closest point by at most one step along edges no longer than the cube's diagonal.
  const double step = 2 * std::sqrt(3.0) / steps;
  EXPECT_NEAR(d.max, largest, step);
  EXPECT_NEAR(d.mean, sum / double(a.points.size() + b.points.size()), step);
}

TEST(Overlap, ShiftedSpheresAgreeWithTheLens) {
  const double h = 1.0 / 32, shift = 0.5;
  // Intersection of two unit spheres at a distance d: pi (4 + d) (2 - d)^2 / 12.
  const double lens = kPi * (4 + shift) * (2 - shift) * (2 - shift) / 12, volume = 4 * kPi / 3;
  const auto a = levelSet(sphere({0, 0, 0}, 1), h, 1.8);
  const auto b = levelSet(sphere({shift, 0, 0}, 1), h, 1.8);
  const auto coarse = levelSet(sphere({shift, 0, 0}, 1), 2 * h, 1.8);
  // The ramp across a voxel is exact for planes; curvature leaves about h^2 / 24 R, trilinear sampling (2
  // h)^2 / 8 R.
  const double fine = 4 * kPi * h * h / 4, mixed = 4 * kPi * 4 * h * h / 4;
  const Overlap same = overlap(*a, *b), other = overlap(*a, *coarse);
  EXPECT_NEAR(same.intersection, lens, fine);
  EXPECT_NEAR(same.symmetricDifference, 2 * (volume - lens), 2 * fine);
  EXPECT_NEAR(same.dice, lens / volume, fine / volume);
  EXPECT_NEAR(other.intersection, lens, mixed);
  EXPECT_NEAR(other.symmetricDifference, 2 * (volume - lens), 2 * mixed);
}

TEST(Overlap, SameNestedAndApart) {
  const double h = 1.0 / 32;
  const auto big = levelSet(sphere({0, 0, 0}, 1), h, 1.3), small = levelSet(sphere({0, 0, 0}, 0.5), h, 1.3);
  const auto far = levelSet(sphere({-3, 0, 0}, 0.25), h, 3.5);
  EXPECT_DOUBLE_EQ(overlap(*big, *big).dice, 1);
  EXPECT_DOUBLE_EQ(overlap(*big, *big).symmetricDifference, 0);
  const double v = 4 * kPi / 3, e = 4 * kPi * h * h / 4;
  EXPECT_NEAR(overlap(*big, *small).intersection, v / 8, e);
  EXPECT_NEAR(overlap(*small, *big).symmetricDifference, v * 7 / 8, e);
  EXPECT_DOUBLE_EQ(overlap(*big, *far).intersection, 0);
  EXPECT_NEAR(overlap(*big, *far).symmetricDifference, v * (1 + 1.0 / 64), e);
  const auto empty = FloatGrid::create(float(3 * h));
  empty->setTransform(big->transform().copy());
  EXPECT_DOUBLE_EQ(overlap(*empty, *empty).dice, 1);
  EXPECT_NEAR(overlap(*big, *empty).symmetricDifference, v, e);
}

/// Where voxels differ much neither grid is resampled to the other: 20 times, some 250,000 leaves.
TEST(Overlap, OfVoxelsOfVeryDifferentSizes) {
  const double h = 0.05, coarseH = 1, r = 1, big = 10;
  const auto small = levelSet(sphere({0, 0, 0}, r), h, 1.3);
  const auto volume = [](double radius) { return 4 * kPi / 3 * radius * radius * radius; };
  // Trilinear sampling of the larger one leaves H^2 / 8 R in each of three directions, over the part of its surface
  // that is within the smaller one; its own volume errs by as much of all its surface.
  const double off = 3 * coarseH * coarseH / (8 * big), all = 4 * kPi * big * big * off;
  const auto around = levelSet(sphere({0, 0, 0}, big), coarseH, 15);
  EXPECT_NEAR(overlap(*small, *around).intersection, volume(r), 0.01);
  EXPECT_NEAR(overlap(*around, *small).symmetricDifference, volume(big) - volume(r), all);
  // Two balls whose surfaces cross: pi (R + r - d)^2 (d^2 + 2 d r - 3 r^2 + 2 d R + 6 r R - 3 R^2) / 12 d.
  const double d = big;
  const auto across = levelSet(sphere({d, 0, 0}, big), coarseH, 24);
  const double lens = kPi * std::pow(big + r - d, 2) *
                      (d * d + 2 * d * r - 3 * r * r + 2 * d * big + 6 * r * big - 3 * big * big) / (12 * d);
  EXPECT_NEAR(overlap(*small, *across).intersection, lens, kPi * r * r * off);
  EXPECT_DOUBLE_EQ(overlap(*small, *levelSet(sphere({-30, 0, 0}, big), coarseH, 45)).intersection, 0);
}

/// Inside tiles of the finer one count, too: it is the larger one here.
TEST(Overlap, OfAFineShapeAroundACoarseOne) {
  const double h = 1.0 / 24;
  const auto fine = levelSet(sphere({0, 0, 0}, 2), h, 2.4);
  const auto coarse = levelSet(sphere({0, 0, 0}, 1.5), 0.75, 4);
  const double v = 4 * kPi / 3 * 1.5 * 1.5 * 1.5, off = 3 * 0.75 * 0.75 / (8 * 1.5);
  EXPECT_NEAR(overlap(*fine, *coarse).intersection, v, 4 * kPi * 1.5 * 1.5 * off);
  EXPECT_NEAR(overlap(*fine, *coarse).dice, 2 * v / (v + 4 * kPi / 3 * 8), 0.2);
}

}  // namespace
}  // namespace slicemorph

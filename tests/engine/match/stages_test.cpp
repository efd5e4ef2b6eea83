// The matching's steps one by one, on spheres in one common chart, whose overlaps and closest
// points are known.
#include "engine/match/closest_points.h"
#include "engine/match/finish_map.h"
#include "engine/match/map_overlap.h"
#include "engine/match/slice_objects.h"
#include "engine/match/take_map.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846, kStageVoxel = 1.0 / 32;

/// Spheres of these radii about these middles; chart space is the world.
struct Sphere {
  Vec3d middle;
  double radius;
};

MatchObjects spheres(const std::vector<Sphere>& list) {
  Fields fields;
  for (const Sphere& s : list)
    fields.push_back(std::make_shared<DistanceField>(
        shapes::levelSet(shapes::sphere(s.middle, s.radius), shapes::cube(s.middle, s.radius), kStageVoxel)));
  return measureObjects(fields, {}, std::vector<Chart>(list.size()), {});
}

/// Every object's displacements from a function of its number and a middle point.
template <typename Function>
Displacements displacements(const MatchObjects& objects, const Function& of) {
  Displacements map{objects.lattice(0.08), {}};
  const Lattice& l = map.lattice;
  for (size_t k = 0; k < objects.count(); ++k) {
    VectorField field(l.count());
    for (int z = 0; z < l.size[2]; ++z)
      for (int y = 0; y < l.size[1]; ++y)
        for (int x = 0; x < l.size[0]; ++x)
          field[l.index(x, y, z)] = openvdb::Vec3s(of(k, l.position(x, y, z)));
    map.of.push_back(std::move(field));
  }
  return map;
}

Displacements none(const MatchObjects& objects) {
  return displacements(objects, [](size_t, const Vec3d&) { return Vec3d(0.0); });
}

/// The ramp over one cell that softens the overlap makes a sphere's volume larger by (spacing / 2
/// radius)^2, here 0.4 % and less; coarse distances are off by a few hundredths of their cells,
/// here 0.2 % of the volume.
constexpr double kOverlapTolerance = 0.006;

TEST(Stages, OverlapOfSpheresInSpheresIsThatOfTheirVolumes) {
  const MatchObjects two = spheres({{{0, 0, 0}, 1}, {{0, 0, 0}, 0.8}});
  EXPECT_NEAR(two.size, 2, kStageVoxel);
  EXPECT_NEAR(mapOverlap(two, none(two)), std::pow(0.8, 3), kOverlapTolerance);
  // Of all pairs of three: what is common of each pair, by what either has.
  const MatchObjects three = spheres({{{0, 0, 0}, 1}, {{0, 0, 0}, 0.9}, {{0, 0, 0}, 0.7}});
  const double a = 1, b = std::pow(0.9, 3), c = std::pow(0.7, 3);
  EXPECT_NEAR(mapOverlap(three, none(three)), (b + c + c) / (a + a + b), kOverlapTolerance);
}

TEST(Stages, AMapThatBringsSpheresTogetherMakesThemOverlap) {
  const double apart = 0.6;
  const MatchObjects objects = spheres({{{0, 0, 0}, 1}, {{apart, 0, 0}, 1}});
  // The lens that two unit spheres have in common: 4 pi / 3 (1 - 3 h / 4 + h^3 / 16), h their distance.
  const double lens = 1 - 0.75 * apart + std::pow(apart, 3) / 16, before = lens / (2 - lens);
  EXPECT_NEAR(mapOverlap(objects, none(objects)), before, kOverlapTolerance);
  const Displacements map = displacements(
      objects, [&](size_t k, const Vec3d&) { return Vec3d(k == 0 ? -apart / 2 : apart / 2, 0, 0); });
  EXPECT_NEAR(mapOverlap(objects, map), 1, kOverlapTolerance);

  Matching start;
  start.map = start.base = none(objects);
  start.overlap = before;
  const TakenMap taken = takeAsFarAsBetter(objects, start, map, {}, "shift");
  EXPECT_EQ(taken.share, 1);
  EXPECT_EQ(taken.matching.map.of, map.of);
  ASSERT_EQ(taken.matching.notes.size(), 1u);
  EXPECT_EQ(taken.matching.notes[0].severity, Severity::kDetail);
  // And back again is no gain.
  const TakenMap refused = takeAsFarAsBetter(objects, taken.matching, start.map, {}, "back");
  EXPECT_EQ(refused.share, 0);
  EXPECT_EQ(refused.matching.map.of, map.of);
  EXPECT_EQ(refused.matching.overlap, taken.matching.overlap);
  // Half the gain that is wanted: taken in part, to a map that lies between.
  const double half = 2 * (mapOverlap(objects, map) - before);
  const TakenMap partly = takeAsFarAsBetter(objects, start, map, {0, half}, "partly");
  EXPECT_GT(partly.share, 0.1);
  EXPECT_LT(partly.share, 0.9);
  const Vec3d shift = partly.matching.map.at(1, Vec3d(apart / 2, 0, 0));
  EXPECT_NEAR(shift[0], partly.share * apart / 2, 1e-5);
  EXPECT_GT(partly.matching.overlap, before);
}

TEST(Stages, StrainOfALinearMapIsItsMatrix) {
  const MatchObjects objects = spheres({{{0, 0, 0}, 1}, {{0, 0, 0}, 0.8}});
  const Mat3d a(0.1, -0.05, 0.0, 0.02, 0.0, 0.03, 0.0, 0.2, -0.1);
  double squares = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) squares += a(i, j) * a(i, j);
  const Displacements map =
      displacements(objects, [&](size_t k, const Vec3d& s) { return (k == 0 ? 1.0 : -1.0) * (a * s); });
  // Differences of values in single precision, some 0.5, over two cells of 0.16: 2e-7.
  EXPECT_NEAR(mapStrain(objects, map), std::sqrt(squares), 1e-6);
}

TEST(Stages, ClosestPointsOfSpheresLieOnTheirRadii) {
  const std::vector<Sphere> list{{{0, 0, 0}, 1}, {{0, 0, 0}, 0.8}};
  const MatchObjects objects = spheres(list);
  Matching matching;
  matching.map = none(objects);
  const std::vector<MiddleSamples> samples = middleSamples(objects, matching, 500);
  const std::vector<Correspondence> points =
      closestPoints(objects.shape.fields, objects.charts, matching.map, samples, 1);
  ASSERT_EQ(points.size(), samples[0].own.size() + samples[1].own.size());
  for (const Correspondence& c : points) {
    const Vec3d ray = c.middle.unit();
    // Near, and facing the same way but for the noise of normals.
    EXPECT_GT(c.weight, 0.95f);
    for (size_t k = 0; k < 2; ++k) EXPECT_LE((c.at[k] - list[k].radius * ray).length(), kStageVoxel);
    EXPECT_NEAR(c.middle.length(), 0.9, kStageVoxel);
  }
  // Beyond the reach nothing is said.
  EXPECT_TRUE(closestPoints(objects.shape.fields, objects.charts, matching.map, samples, 0.15).empty());
}

TEST(Stages, SlicesOfASphereAreCircles) {
  const MatchObjects objects = spheres({{{0, 0, 0}, 1}, {{0, 0, 0}, 1}});
  const TracedObjects traced = traceObjects(sliceObjects(objects, 16));
  ASSERT_EQ(traced.stacks.size(), 2u);
  ASSERT_EQ(traced.planes.z0.size(), 16u);
  for (size_t k = 0; k < 2; ++k)
    for (size_t i = 0; i < 16; ++i) {
      const double z = traced.position[k][i];
      EXPECT_NEAR(z, traced.planes.z0[i], 1e-9) << "equal objects have equal positions";
      ASSERT_EQ(traced.stacks[k][i].size(), 1u) << i;
      // Half a pixel along the rim.
      const double radius = std::sqrt(1 - z * z), tolerance = kPi * radius * traced.planes.pixel;
      EXPECT_NEAR(traced.stacks[k][i][0].area, kPi * radius * radius, tolerance) << i;
    }
}

TEST(Stages, ThinnedSamplesKeepTheWholeMass) {
  const MatchObjects objects = spheres({{{0, 0, 0}, 1}});
  const ChartSamples& all = objects.shape.samples[0];
  EXPECT_NEAR(all.area, 4 * kPi, 0.05 * 4 * kPi);
  const OrientedPoints some = thinned(all, 600, objects.box.min());
  EXPECT_LT(some.position.size(), 900u);
  EXPECT_GT(some.position.size(), 400u);
  double mass = 0;
  for (double m : some.mass) mass += m;
  EXPECT_NEAR(mass, 1, 1e-9);
  // One of every bin, none a mean: all are samples themselves.
  for (const Vec3d& p : some.position)
    EXPECT_NE(std::find(all.points.position.begin(), all.points.position.end(), p),
              all.points.position.end());
}

/// The objects have moved: nodes keep their values, and new nodes take those of the outermost ones.
TEST(Stages, AContinuedMapKeepsItsNodes) {
  const MatchObjects before = spheres({{{0, 0, 0}, 1}, {{0, 0, 0}, 0.8}});
  const Displacements map =
      displacements(before, [](size_t k, const Vec3d& s) { return 0.1 * double(k + 1) * s; });
  const MatchObjects now = spheres({{{1, 0, 0}, 1}, {{1, 0, 0}, 0.8}});
  const Displacements next = continuedOver(now, map);
  const Vec3d end = map.lattice.position(map.lattice.size[0] - 1, 0, 0);
  const Lattice& l = next.lattice;
  EXPECT_EQ(l.spacing, map.lattice.spacing);
  EXPECT_LE(l.origin[0], now.reach().min()[0]);
  EXPECT_GE(l.position(l.size[0] - 1, 0, 0)[0], now.reach().max()[0]);
  for (int x = 0; x < l.size[0]; ++x) {
    const Vec3d s = l.position(x, l.size[1] / 2, l.size[2] / 2);
    for (size_t k = 0; k < 2; ++k) {
      const double there = double(next.of[k][l.index(x, l.size[1] / 2, l.size[2] / 2)][0]);
      EXPECT_NEAR(there, 0.1 * double(k + 1) * std::min(s[0], end[0]), 1e-6) << x;
    }
  }
}

}  // namespace
}  // namespace slicemorph

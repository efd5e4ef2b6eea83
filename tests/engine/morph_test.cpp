// The pipeline against closed forms: the in-betweens of two known shapes. Tolerances are those that the
// project promises, in voxels of the frame. Shapes have 128 voxels along the longest side; with
// SLICEMORPH_ALL_TESTS, and always for one turning bar, the 256 of the promise.
#include "engine/measure/measure.h"
#include "engine/spine/chart.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/all_tests.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"
#include "tests/support/surface_checks.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <random>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
using shapes::Distance;

Object object(const FloatGrid::Ptr& grid, const char* name = "shape") { return {name, grid}; }

Weights at(double t) { return {1 - t, t}; }

/// Voxels along the longest side.
double resolution() { return allTests() ? 256 : 128; }

struct Errors {
  double mean = 0, max = 0;  ///< voxels
};

/// Distance of the surface's vertices to a closed form.
Errors errorsTo(const FloatGrid& grid, const Distance& truth) {
  const Mesh mesh = surfaceOf(grid);
  Errors e;
  for (const auto& p : mesh.points) {
    const double d = std::abs(truth(Vec3d(p))) / grid.voxelSize()[0];
    e.mean += d / double(mesh.points.size());
    e.max = std::max(e.max, d);
  }
  return e;
}

TEST(Morph, SphereShrinksLinearly) {
  const MorphPlan plan(
      {object(shapes::levelSet(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1), 2 / resolution())),
       object(shapes::levelSet(shapes::sphere({0, 0, 0}, 0.5), shapes::cube({0, 0, 0}, 0.5),
                               1 / resolution()))});
  for (double t : {0.1, 0.25, 0.5, 0.75, 0.9})
    EXPECT_LE(errorsTo(*plan.frame(at(t)).surface, shapes::sphere({0, 0, 0}, 1 - 0.5 * t)).max, 0.25)
        << "t " << t;
}

TEST(Morph, SphereTravelsWhole) {
  const double h = 2 / resolution();
  const Vec3d far(2.3, -1.1, 3.1);  // four radii away
  const MorphPlan plan({object(shapes::levelSet(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1), h)),
                        object(shapes::levelSet(shapes::sphere(far, 1), shapes::cube(far, 1), h))});
  for (double t : {0.2, 0.5, 0.7}) {
    const FloatGrid::Ptr frame = plan.frame(at(t)).surface;
    EXPECT_LE(errorsTo(*frame, shapes::sphere(t * far, 1)).mean, 0.1) << "t " << t;
    EXPECT_NEAR(measureShape(*frame).volume, 4 * kPi / 3, 0.005 * 4 * kPi / 3) << "t " << t;
  }
}

/// A bar with three different sides that is turned, moved and scaled: half way it must be turned, moved and
/// scaled by half.
void expectBarTurns(double degrees, const Vec3d& axis, const Vec3d& offset, double scale, double voxels) {
  const Vec3d half(1, 0.32, 0.21);
  const Distance bar = shapes::box(half, 0.05);
  const Vec3d turn = axis.unit() * (degrees * kPi / 180);
  const double h = 2 / voxels;
  const MorphPlan plan({object(shapes::levelSet(bar, shapes::cube({0, 0, 0}, 1.1), h)),
                        object(shapes::levelSet(shapes::placed(bar, rotationFromVector(turn), offset, scale),
                                                shapes::cube(offset, 1.1 * scale), h * scale))});
  const Distance truth = shapes::placed(bar, rotationFromVector(0.5 * turn), 0.5 * offset, 0.5 + 0.5 * scale);
  const Errors e = errorsTo(*plan.frame(at(0.5)).surface, truth);
  EXPECT_LE(e.mean, 0.1) << degrees << " degrees";
  EXPECT_LE(e.max, 1.0) << degrees << " degrees";
}

TEST(Morph, BarTurnsByARightAngle) { expectBarTurns(90, {0, 0, 1}, {0, 0, 0}, 1, resolution()); }
TEST(Morph, BarTurnsBy30MovedAndScaled) {
  expectBarTurns(30, {1, 2, 3}, {0.7, -1.3, 0.4}, 1.7, resolution());
}
TEST(Morph, BarTurnsBy75MovedAndScaled) { expectBarTurns(75, {1, 2, 3}, {0.7, -1.3, 0.4}, 1.7, 256); }

/// The lattice's margin is a share of the objects' size, so with large voxels the narrow band
/// reaches beyond it.
void expectWholeBand(double voxels) {
  const double h = 2 / voxels;
  const Distance bar = shapes::box({1, 0.32, 0.21}, 0.05);
  const auto turned = [&](double degrees, double x) {
    return shapes::placed(bar, rotationFromVector({0, 0, degrees * kPi / 180}), {x, 0, 0});
  };
  const MorphPlan plan({object(shapes::levelSet(turned(60, 0), shapes::cube({0, 0, 0}, 1.1), h)),
                        object(shapes::levelSet(turned(0, 3), shapes::cube({3, 0, 0}, 1.1), h))});
  for (double t : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    const FloatGrid::Ptr frame = plan.frame(at(t)).surface;
    EXPECT_EQ(checks::closedAndManifold(surfaceOf(*frame)), "") << "t " << t;
    EXPECT_EQ(measureShape(*frame).pieces, 1) << "t " << t;
    const Distance truth = turned(60 * (1 - t), 3 * t);
    const auto accessor = frame->getConstAccessor();
    int missing = 0, wrongSide = 0;
    const Vec3d middle(3 * t, 0, 0), reach(1.3);
    const openvdb::CoordBBox box(openvdb::Coord::floor((middle - reach) / h),
                                 openvdb::Coord::ceil((middle + reach) / h));
    for (auto c = box.begin(); c; ++c) {
      const double d = truth(h * (*c).asVec3d());
      // One voxel less than the half width, since the surface is met to one voxel; outside only, since the
      // bar is thinner than its band.
      missing += d > 0 && d < (kHalfWidth - 1) * h && !accessor.isValueOn(*c);
      wrongSide += std::abs(d) > h && (accessor.getValue(*c) < 0) != (d < 0);
    }
    EXPECT_EQ(missing, 0) << "t " << t;
    EXPECT_EQ(wrongSide, 0) << "t " << t;
  }
}

TEST(Morph, BandOfLargeVoxelsIsWhole) { expectWholeBand(48); }
TEST(Morph, BandOfVeryLargeVoxelsIsWhole) { expectWholeBand(24); }

/// A plain bar turned by 120 degrees could also have turned another way by its symmetry; one with four knobs
/// could not. They are in opposite pairs, so that the centroid stays the same.
TEST(Morph, UnsymmetricBarTurnsBy120) {
  const Distance body = shapes::box({1, 0.32, 0.21}, 0.05);
  const Distance shape = [=](const Vec3d& p) {
    const double knob =
        std::min((p - Vec3d(0.6, 0.3, 0.05)).length(), (p + Vec3d(0.6, 0.3, 0.05)).length()) - 0.28;
    const double ear =
        std::min((p - Vec3d(0.1, 0.15, 0.2)).length(), (p + Vec3d(0.1, 0.15, 0.2)).length()) - 0.22;
    return std::min({body(p), knob, ear});
  };
  const Vec3d turn = Vec3d(1, 2, 3).unit() * (2 * kPi / 3), offset(0.7, -1.3, 0.4);
  const double h = 2 / resolution();
  const MorphPlan plan({object(shapes::levelSet(shape, shapes::cube({0, 0, 0}, 1.3), h)),
                        object(shapes::levelSet(shapes::placed(shape, rotationFromVector(turn), offset, 1.7),
                                                shapes::cube(offset, 2.2), 1.7 * h))});
  const Errors e = errorsTo(*plan.frame(at(0.5)).surface,
                            shapes::placed(shape, rotationFromVector(0.5 * turn), 0.5 * offset, 1.35));
  EXPECT_LE(e.mean, 0.1);
  EXPECT_LE(e.max, 1.0);
}

FloatGrid::Ptr ballGrid() {
  return shapes::levelSet(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1), 2 / resolution());
}

FloatGrid::Ptr torusGrid() {
  return shapes::levelSet(shapes::torus({0, 0, 0}, 0.8, 0.3), shapes::cube({0, 0, 0}, 1.2), 2 / resolution());
}

/// The plan from a ball to a torus, made once for several tests.
const MorphPlan& openingPlan() {
  static const MorphPlan plan({object(ballGrid()), object(torusGrid())});
  return plan;
}

TEST(Morph, SphereOpensIntoATorusOnce) {
  const MorphPlan& plan = openingPlan();
  int changes = 0, genus = 0;
  for (int i = 0; i < 25; ++i) {
    const InBetween frame = plan.frame(at(i / 24.0));
    const ShapeMeasures m = measureShape(*frame.surface);
    EXPECT_EQ(m.pieces, 1) << "frame " << i + 1;
    EXPECT_EQ(frame.foldShare, 0) << "frame " << i + 1;
    if (m.genus != genus) ++changes, genus = m.genus;
  }
  EXPECT_EQ(changes, 1);
  EXPECT_EQ(genus, 1);
}

/// Two lumpy shapes without symmetry, for the tests of stability.
Distance lumpy(int seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-0.45, 0.45), size(0.2, 0.4);
  std::vector<std::pair<Vec3d, double>> balls{{{0, 0, 0}, 0.6}};
  for (int i = 0; i < 5; ++i) {
    const Vec3d centre(1.4 * coordinate(random), coordinate(random), coordinate(random));
    balls.emplace_back(centre, size(random));
  }
  return [=](const Vec3d& p) {
    double d = 1e9;
    for (const auto& [centre, radius] : balls) d = std::min(d, (p - centre).length() - radius);
    return d;
  };
}

FloatGrid::Ptr lumpyGrid(int seed) {
  return shapes::levelSet(lumpy(seed), shapes::cube({0, 0, 0}, 1.2), 2.0 / 128);
}

/// The plan between two lumpy shapes, made once for several tests.
const MorphPlan& lumpyPlan() {
  static const MorphPlan plan({object(lumpyGrid(1)), object(lumpyGrid(2))});
  return plan;
}

TEST(Morph, NoChangeIsExactlyNoChange) {
  const FloatGrid::Ptr grid = lumpyGrid(1);
  const MorphPlan plan({object(grid), object(lumpyGrid(1))});
  for (double t : {0.0, 0.3, 0.5, 1.0})
    EXPECT_TRUE(sameValues(*plan.frame(at(t)).surface, *grid)) << "t " << t;
}

TEST(Morph, EndFramesAreTheInputs) {
  const FloatGrid::Ptr a = lumpyGrid(1), b = lumpyGrid(2);
  const MorphPlan& plan = lumpyPlan();
  EXPECT_TRUE(sameValues(*plan.frame(at(0)).surface, *a));
  EXPECT_TRUE(sameValues(*plan.frame(at(1)).surface, *b));
  // In-betweens converge to the ends: very near to one the surface differs only by what linear interpolation
  // rounds off at creases, up to half a voxel.
  const SurfaceDistance d = surfaceDistance(surfaceOf(*plan.frame(at(1e-4)).surface), surfaceOf(*a));
  EXPECT_LE(d.max, 0.5 * a->voxelSize()[0]);
}

TEST(Morph, SwappedInputsGiveTheSameSurfaces) {
  const MorphPlan back({object(lumpyGrid(2)), object(lumpyGrid(1))});
  for (double t : {0.25, 0.5}) {
    const FloatGrid::Ptr x = lumpyPlan().frame(at(t)).surface, y = back.frame(at(1 - t)).surface;
    const SurfaceDistance d = surfaceDistance(surfaceOf(*x), surfaceOf(*y));
    EXPECT_LE(d.max, 0.1 * x->voxelSize()[0]) << "t " << t;
  }
}

TEST(Morph, NoiseOfAHundredthVoxelMovesLittle) {
  const FloatGrid::Ptr noisy = lumpyGrid(1);
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.f, 0.01f * float(noisy->voxelSize()[0]));
  for (auto it = noisy->beginValueOn(); it; ++it) it.setValue(*it + noise(random));
  const FloatGrid::Ptr x = lumpyPlan().frame(at(0.5)).surface;
  const FloatGrid::Ptr y = MorphPlan({object(noisy), object(lumpyGrid(2))}).frame(at(0.5)).surface;
  EXPECT_LE(surfaceDistance(surfaceOf(*x), surfaceOf(*y)).max, 0.5 * x->voxelSize()[0]);
}

TEST(Morph, NoiseDoesNotTurnARoundShape) {
  std::mt19937 random(11);
  const FloatGrid::Ptr first = openingPlan().frame(at(0.5)).surface;
  for (int i = 0; i < (allTests() ? 2 : 1); ++i) {
    const FloatGrid::Ptr ball = ballGrid();
    const double h = ball->voxelSize()[0];
    std::normal_distribution<float> noise(0.f, 0.01f * float(h));
    for (auto it = ball->beginValueOn(); it; ++it) it.setValue(*it + noise(random));
    const FloatGrid::Ptr frame = MorphPlan({object(ball), object(torusGrid())}).frame(at(0.5)).surface;
    EXPECT_LE(surfaceDistance(surfaceOf(*frame), surfaceOf(*first)).max, 0.5 * h);
  }
}

TEST(Morph, ThreadsDoNotChangeAValue) {
  if (!allTests())
    GTEST_SKIP() << "limbs_test and command_test compare threads, too; SLICEMORPH_ALL_TESTS=1 runs it";
  const FloatGrid::Ptr a = lumpyGrid(1), b = lumpyGrid(2);
  FloatGrid::Ptr first;
  for (size_t threads : {1, 2, 4})
    withThreads(threads, [&] {
      const FloatGrid::Ptr frame = MorphPlan({object(a), object(b)}).frame(at(0.4)).surface;
      if (!first) first = frame;
      EXPECT_TRUE(sameValues(*frame, *first)) << threads << " threads";
    });
}

TEST(Morph, FramesAreLevelSets) {
  const FloatGrid::Ptr frame = lumpyPlan().frame(at(0.5)).surface;
  const double h = frame->voxelSize()[0];
  EXPECT_EQ(frame->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_EQ(frame->getName(), "surface");
  EXPECT_NEAR(frame->background(), 3 * h, 1e-6 * h);
  EXPECT_EQ(checks::closedAndManifold(surfaceOf(*frame)), "");
  // A distance has a gradient of length 1; at the shapes' creases it is less.
  double sum = 0;
  size_t count = 0;
  auto accessor = frame->getConstAccessor();
  for (auto it = frame->cbeginValueOn(); it; ++it) {
    if (std::abs(*it) > 1.5 * h) continue;
    Vec3d g;
    for (int a = 0; a < 3; ++a) {
      openvdb::Coord e(0, 0, 0);
      e[a] = 1;
      g[a] = (accessor.getValue(it.getCoord() + e) - accessor.getValue(it.getCoord() - e)) / (2 * h);
    }
    sum += std::abs(g.length() - 1), ++count;
  }
  EXPECT_LE(sum / double(count), 0.05);
}

TEST(Morph, RefusesWrongWeightsAndOptions) {
  const FloatGrid::Ptr a = lumpyGrid(1);
  const MorphPlan& plan = lumpyPlan();
  EXPECT_THROW(plan.frame({1}), InputError);
  EXPECT_THROW(plan.frame({0.5, 0.6}), InputError);
  EXPECT_THROW(plan.frame({1.6, -0.6}), InputError);
  EXPECT_THROW(plan.frame({std::nan(""), 1}), InputError);
  MorphOptions options;
  options.slices = 2;
  EXPECT_THROW(MorphPlan({object(a)}, options), InputError);
  EXPECT_THROW(MorphPlan({}), InputError);
  EXPECT_THROW(MorphPlan({object(FloatGrid::create(1.f))}), GeometryError);
}

TEST(Morph, KeepsWorldPositionsWhenTold) {
  MorphOptions options;
  options.align = Align::kNone;
  const double h = 2.0 / 128;
  const MorphPlan plan(
      {object(shapes::levelSet(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1), h)),
       object(shapes::levelSet(shapes::sphere({0, 0, 0}, 0.6), shapes::cube({0, 0, 0}, 1), h))},
      options);
  EXPECT_LE(errorsTo(*plan.frame(at(0.5)).surface, shapes::sphere({0, 0, 0}, 0.8)).max, 0.5);
}

class Cancelling : public Progress {
 public:
  bool cancelled() const override { return true; }
};

TEST(Morph, CanBeCancelled) {
  Cancelling cancel;
  EXPECT_THROW(MorphPlan({object(lumpyGrid(1)), object(lumpyGrid(2))}, {}, &cancel), Cancelled);
}

}  // namespace
}  // namespace slicemorph

// Features prescribed by an artist: points, lines and disks that correct a match. Legs are tested at 128
// voxels along the longest side, since they are thin, points at 64.
#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/quadruped.h"
#include "tests/support/same_values.h"
#include "tests/support/section_parts.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
using shapes::capsule;
using shapes::Distance;
using shapes::joined;

using shapes::Quadruped;
using Swing = Quadruped::Swing;

Object quadruped(const Swing& swing, double voxels) {
  return {"quadruped", shapes::levelSet(shapes::quadruped(swing), shapes::quadrupedBox(), 1.9 / voxels)};
}

/// Two lines per leg: from the hip to the knee and from the knee to the foot.
std::vector<Feature> legLines(const Swing& a, const Swing& b) {
  std::vector<Feature> lines;
  for (int leg = 0; leg < 4; ++leg)
    for (int half = 0; half < 2; ++half) {
      Feature line{"leg " + std::to_string(leg) + (half ? " below" : " above"), Feature::Kind::kLine, {}};
      for (const Swing& s : {a, b})
        line.positions.push_back({Quadruped::onLeg(leg, s[size_t(leg)], 0.5 * half),
                                  Quadruped::onLeg(leg, s[size_t(leg)], 0.5 * half + 0.5)});
      lines.push_back(std::move(line));
    }
  return lines;
}

/// Legs that swing by 50 degrees and cross stay separate at all 25 times.
TEST(Features, LinesKeepFourLegs) {
  const Swing still{0, 0, 0, 0}, running{50, -50, 50, -50};
  const Object a = quadruped(still, 128), b = quadruped(running, 128);
  MorphOptions options;
  options.features = legLines(still, running);
  const MorphPlan plan({a, b}, options);
  for (const Note& note : plan.notes()) std::printf("  %s\n", note.sentence().c_str());
  const double volumeA = measureShape(*a.levelSet).volume, volumeB = measureShape(*b.levelSet).volume;
  for (int i = 0; i < 25; ++i) {
    const double t = i / 24.0;
    const InBetween frame = plan.frame({1 - t, t});
    const ShapeMeasures m = measureShape(*frame.surface);
    const double volume = m.volume / ((1 - t) * volumeA + t * volumeB);
    // Sections below the body, half way down the legs, and above the highest feet.
    const int upper = sectionParts(*frame.surface, 2, 0.2), middle = sectionParts(*frame.surface, 2, 0.1),
              low = sectionParts(*frame.surface, 2, 0.0);
    std::printf("  t %.3f: pieces %d, genus %d, legs %d, %d and %d, volume %.3f, fold %.4f\n", t, m.pieces,
                m.genus, upper, middle, low, volume, frame.foldShare);
    EXPECT_EQ(m.pieces, 1) << "t " << t;
    EXPECT_EQ(upper, 4) << "t " << t;
    EXPECT_EQ(middle, 4) << "t " << t;
    EXPECT_EQ(low, 4) << "t " << t;
    EXPECT_EQ(m.genus, 0) << "t " << t;
    EXPECT_GE(volume, 0.93) << "t " << t;
  }
}

/// Thick at one end, thin at the other, with a fin on top so that no other symmetry is left.
Object fish(double thickAt) {
  const double s = thickAt;
  const Distance shape = joined({capsule({0.6 * s, 0, 0}, {0.3 * s, 0, 0}, 0.35),
                                 capsule({0.4 * s, 0, 0}, {-0.9 * s, 0, 0}, 0.16),
                                 capsule({0.2 * s, 0, 0.2}, {0, 0, 0.5}, 0.1)});
  return {"fish",
          shapes::levelSet(shape, openvdb::BBoxd(Vec3d(-1.3, -0.6, -0.6), Vec3d(1.3, 0.6, 0.8)), 2.0 / 64)};
}

Feature point(const std::string& name, const Vec3d& a, const Vec3d& b) {
  return {name, Feature::Kind::kPoint, {{a}, {b}}};
}

/// The shapes alone match thick end to thick end. Three points prescribe thick end to thin end.
TEST(Features, ThreePointsTurnAMatchRound) {
  const Object a = fish(1), b = fish(1);
  const Object thinNose = {"thin nose", fish(-1).levelSet};
  const Vec3d nose(0.95, 0, 0), tail(-1.06, 0, 0), fin(0, 0, 0.6);
  const Vec3d thinTail(1.06, 0, 0);  // of the other one: its thin end is at +x
  const auto arrives = [&](const MorphPlan& plan) { return plan.correspond({nose, tail}, 0, 1); };
  const std::vector<Vec3d> wrong = arrives(MorphPlan({a, thinNose}));
  EXPECT_GE((wrong[0] - thinTail).length(), 1.0) << "the shapes alone should match thick to thick";
  MorphOptions options;
  options.features = {point("nose", nose, thinTail), point("tail", tail, {-0.95, 0, 0}),
                      point("fin", fin, fin)};
  const MorphPlan plan({a, thinNose}, options);
  const std::vector<Vec3d> right = arrives(plan);
  const double h = a.levelSet->voxelSize()[0];
  std::printf("  nose off by %.2f voxels, tail by %.2f (without %.1f)\n", (right[0] - thinTail).length() / h,
              (right[1] - Vec3d(-0.95, 0, 0)).length() / h, (wrong[0] - thinTail).length() / h);
  EXPECT_LE((right[0] - thinTail).length() / h, 2);
  EXPECT_LE((right[1] - Vec3d(-0.95, 0, 0)).length() / h, 2);
  const InBetween half = plan.frame({0.5, 0.5});
  EXPECT_EQ(measureShape(*half.surface).pieces, 1);
  EXPECT_LE(half.foldShare, 0.001);
}

/// Three points on the spine of both: points on one line also decide which end is which.
TEST(Features, PointsInALineTurnItToo) {
  const Object a = fish(1), b = {"thin nose", fish(-1).levelSet};
  MorphOptions options;
  options.features = {point("nose", {0.95, 0, 0}, {1.06, 0, 0}), point("middle", {0, 0, 0}, {0, 0, 0}),
                      point("tail", {-1.06, 0, 0}, {-0.95, 0, 0})};
  const std::vector<Vec3d> right = MorphPlan({a, b}, options).correspond({{0.95, 0, 0}}, 0, 1);
  EXPECT_LE((right[0] - Vec3d(1.06, 0, 0)).length() / a.levelSet->voxelSize()[0], 2);
}

TEST(Features, AFarOneChangesNothing) {
  const Object a = fish(1), b = fish(0.7);
  const FloatGrid::Ptr without = MorphPlan({a, b}).frame({0.5, 0.5}).surface;
  for (double far : {2.0, 10.0}) {
    MorphOptions options;
    options.features = {point("moon", {0, 0, far}, {far, 0, 0})};
    const MorphPlan plan({a, b}, options);
    const FloatGrid::Ptr with = plan.frame({0.5, 0.5}).surface;
    const SurfaceDistance d = surfaceDistance(surfaceOf(*with), surfaceOf(*without));
    EXPECT_LE(d.max / a.levelSet->voxelSize()[0], 0.1);
    bool named = false;
    for (const Note& note : plan.notes()) named |= note.sentence().find("'moon'") != std::string::npos;
    EXPECT_TRUE(named);
  }
}

/// Two points whose paths cross: a warning names both, and nothing folds.
TEST(Features, ContradictionsAreNamed) {
  const Object a = fish(1), b = quadruped({0, 0, 0, 0}, 64);
  MorphOptions options;
  options.features = {
      point("left", {0.5, 0.3, 0.1}, {0.5, -0.17, 0.45}), point("right", {0.5, -0.3, 0.1}, {0.5, 0.17, 0.45}),
      point("nose", {0.95, 0, 0}, {1.08, 0, 0.78}),       point("tail", {-1.06, 0, 0}, {-0.9, 0, 0.3}),
      point("top", {0.4, 0, 0.35}, {0.4, 0, 0.62}),       point("below", {0.4, 0, -0.35}, {0.4, 0, 0.28})};
  const MorphPlan plan({a, b}, options);
  bool warned = false;
  for (const Note& note : plan.notes()) {
    std::printf("  %s\n", note.sentence().c_str());
    warned |= note.code == "features.contradict" && note.severity == Severity::kWarning &&
              note.text.find("'left'") != std::string::npos && note.text.find("'right'") != std::string::npos;
  }
  EXPECT_TRUE(warned);
  for (double t : {0.25, 0.5, 0.75}) {
    const InBetween frame = plan.frame({1 - t, t});
    EXPECT_EQ(frame.foldShare, 0) << "t " << t;
    EXPECT_EQ(measureShape(*frame.surface).pieces, 1) << "t " << t;
  }
}

/// A disk prescribes the position and width of a section: the waist of one bar moves to that of the other, at
/// another position along it.
TEST(Features, ADiskMovesASection) {
  const auto bar = [](double neck) {
    const Distance shape = [=](const Vec3d& p) {
      const double waist = 0.4 - 0.15 * std::exp(-std::pow((p[0] - neck) / 0.2, 2));
      const double r = std::hypot(p[1], p[2]) - waist, x = std::abs(p[0]) - 1.5;
      return std::hypot(std::max(r, 0.0), std::max(x, 0.0)) + std::min(std::max(r, x), 0.0);
    };
    return Object{"bar", shapes::levelSet(
                             shape, openvdb::BBoxd(Vec3d(-1.8, -0.6, -0.6), Vec3d(1.8, 0.6, 0.6)), 3.0 / 64)};
  };
  const Object a = bar(-0.5), b = bar(0.5);
  Feature disk{"waist", Feature::Kind::kDisk, {{{-0.5, 0, 0}}, {{0.5, 0, 0}}}};
  disk.normals = {{1, 0, 0}, {1, 0, 0}}, disk.radii = {0.25, 0.25};
  MorphOptions options;
  options.features = {disk};
  const std::vector<Vec3d> there =
      MorphPlan({a, b}, options).correspond({{-0.5, 0.25, 0}, {-0.5, 0, -0.25}}, 0, 1);
  const double h = a.levelSet->voxelSize()[0];
  EXPECT_LE((there[0] - Vec3d(0.5, 0.25, 0)).length() / h, 2);
  EXPECT_LE((there[1] - Vec3d(0.5, 0, -0.25)).length() / h, 2);
}

}  // namespace
}  // namespace slicemorph

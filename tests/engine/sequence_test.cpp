// Plans from frame to frame of a sequence: decisions are kept, follow the objects and cause no jumps.
#include "engine/frame/track.h"
#include "engine/measure/measure.h"
#include "engine/volume/moments.h"
#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/all_tests.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <random>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kFrames = 10;
constexpr double kVoxel = 2.0 / 48;
using shapes::Distance;

Object object(const FloatGrid::Ptr& grid) { return {"shape", grid}; }

Weights at(double t) { return {1 - t, t}; }

/// A first-order distance from any smooth function that is negative inside.
Distance distanceOf(const Distance& f) {
  return [=](const Vec3d& p) {
    constexpr double e = 1e-4;
    const Vec3d g(f(p + Vec3d(e, 0, 0)) - f(p - Vec3d(e, 0, 0)),
                  f(p + Vec3d(0, e, 0)) - f(p - Vec3d(0, e, 0)),
                  f(p + Vec3d(0, 0, e)) - f(p - Vec3d(0, 0, e)));
    return f(p) / std::max(g.length() / (2 * e), 0.3);
  };
}

Distance ellipsoid(const Vec3d& axes) {
  return distanceOf([=](const Vec3d& p) {
    return ((p / axes).length() - 1) * std::min({axes[0], axes[1], axes[2]});
  });
}

/// A ball of radius 0.7 with bumps of a tenth.
Distance bumpy() {
  return distanceOf([](const Vec3d& p) {
    const Vec3d n = p / std::max(p.length(), 1e-6);
    const double bumps = std::sin(3 * n[0] + 1) + std::sin(4 * n[1] + 2 * n[0]) + std::sin(4 * n[2] - n[1]);
    return p.length() - 0.7 - 0.07 * bumps;
  });
}

/// Smoothly merged balls whose radii and positions oscillate with `phase`.
Distance cloud(unsigned seed, double phase) {
  struct Ball {
    Vec3d centre;
    double radius;
  };
  std::vector<Ball> balls;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 14; ++i) {
    Vec3d c(any(random), any(random), any(random));
    c = 0.55 * c / std::max(1.0, c.length());
    const double start = kPi * any(random);
    c += 0.08 * Vec3d(std::sin(phase + start), std::cos(phase + 2 * start), std::sin(phase - start));
    balls.push_back({c * Vec3d(1.2, 1, 0.8), 0.34 * (1 + 0.2 * std::sin(phase + 3 * start))});
  }
  return [=](const Vec3d& p) {
    double sum = 0;
    for (const Ball& b : balls) sum += std::exp(-30 * ((p - b.centre).length() - b.radius));
    return -std::log(sum) / 30;
  };
}

Mat3d aboutZ(double degrees) { return rotationFromVector({0, 0, degrees * kPi / 180}); }

using Sequence = std::vector<FloatGrid::Ptr>;  ///< per frame

template <typename Shape>
Sequence sequence(const Shape& shape) {
  Sequence result;
  for (int i = 0; i < kFrames; ++i)
    result.push_back(shapes::levelSet(shape(i), shapes::cube({0, 0, 0}, 1.3), kVoxel));
  return result;
}

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Plans {
  std::vector<MorphPlan> frames;
  double first = 0, next = 0;  ///< seconds; of the first, and in the mean of the others
};

Plans plansOf(const Sequence& a, const Sequence& b, bool follow) {
  Plans plans;
  for (size_t i = 0; i < a.size(); ++i) {
    const double start = seconds();
    const std::vector<Object> objects{object(a[i]), object(b[i])};
    if (follow && i > 0)
      plans.frames.emplace_back(objects, plans.frames.back());
    else
      plans.frames.emplace_back(objects);
    (i > 0 ? plans.next : plans.first) += (seconds() - start) / (i > 0 ? double(a.size() - 1) : 1);
  }
  return plans;
}

/// Largest difference from one frame to the next over their mean.
template <typename Time>
double popOf(const std::vector<MorphPlan>& plans, const Time& time) {
  double sum = 0, largest = 0;
  FloatGrid::Ptr before;
  for (size_t i = 0; i < plans.size(); ++i) {
    const FloatGrid::Ptr now = plans[i].frame(at(time(i))).surface;
    if (before) {
      const double d = overlap(*before, *now).symmetricDifference;
      sum += d, largest = std::max(largest, d);
    }
    before = now;
  }
  return largest * double(plans.size() - 1) / sum;
}

/// Prints the jumps of a sequence of plans, with t running from 0 to 1 and with t held at 0.5, and the
/// time of planning.
void report(const char* name, const Plans& plans, double playing, double held) {
  std::printf("%s: largest jump over the mean %.2f playing, %.2f held half way; ", name, playing, held);
  std::printf("%.2f s for the first plan, %.2f for each other\n", plans.first, plans.next);
}

double playing(size_t i) { return double(i) / (kFrames - 1); }
double held(size_t) { return 0.5; }

void expectNoJumps(const Sequence& a, const Sequence& b) {
  const Plans plans = plansOf(a, b, true);
  const double played = popOf(plans.frames, playing), halfWay = popOf(plans.frames, held);
  report("followed", plans, played, halfWay);
  EXPECT_LE(played, 1.5);
  EXPECT_LE(halfWay, 1.5);
}

void reportAnew(const Sequence& a, const Sequence& b) {
  const Plans plans = plansOf(a, b, false);
  report("planned anew", plans, popOf(plans.frames, playing), popOf(plans.frames, held));
}

/// An ellipsoid whose two longest axes swap. It is larger than the other shape by about as much as makes the
/// change by shrinking balance, frame for frame, the change that the other's turn adds.
Sequence crossing() {
  return sequence([](int i) { return ellipsoid({1.1 - 0.2 * i / 9, 0.9 + 0.2 * i / 9, 0.75}); });
}
Sequence turning() {
  return sequence([](int i) { return shapes::placed(bumpy(), aboutZ(10 * i), {0, 0, 0}); });
}
Sequence billowing(unsigned seed) {
  return sequence([=](int i) { return cloud(seed, 0.3 * i); });
}

TEST(Sequence, AxesThatCrossAndATurningBlob) { expectNoJumps(crossing(), turning()); }
TEST(Sequence, BillowingClouds) {
  if (!allTests()) GTEST_SKIP() << "fog_test.py has clouds; SLICEMORPH_ALL_TESTS=1 runs it";
  expectNoJumps(billowing(1), billowing(2));
}

// For comparison; too slow to be run regularly.
TEST(Sequence, DISABLED_PlannedAnew) {
  reportAnew(crossing(), turning());
  reportAnew(billowing(1), billowing(2));
}

const Vec3d kBar(1, 0.32, 0.21);

FloatGrid::Ptr bar(double degrees, const Vec3d& offset = {0, 0, 0}) {
  const Distance shape = shapes::placed(shapes::box(kBar, 0.05), aboutZ(degrees), offset);
  return shapes::levelSet(shape, shapes::cube(offset, 1.1), 2.0 / 72);
}

const FloatGrid::Ptr& stillBar() {
  static const FloatGrid::Ptr grid = bar(0, {3, 0, 0});
  return grid;
}

/// A plan between a bar and the same bar at another position.
const MorphPlan& firstPlan() {
  static const MorphPlan plan({object(bar(0)), object(stillBar())});
  return plan;
}

/// Direction of the longest axis about z, degrees, from -90 to 90.
double directionOf(const FloatGrid::Ptr& grid) {
  const Mat3d axes = principalAxes(insideMoments(DistanceField(grid)).covariance).axes;
  return std::atan(axes(1, 0) / axes(0, 0)) * 180 / kPi;
}

/// Difference of two directions of an axis, degrees, from -90 to 90.
double between(double a, double b) { return std::remainder(a - b, 180); }

TEST(Sequence, TurningBarIsFollowedTheLongWay) {
  const FloatGrid::Ptr& still = stillBar();
  std::optional<MorphPlan> plan;
  double before = 0;
  for (int degrees = 10; degrees <= 100; degrees += 10) {
    const std::vector<Object> objects{object(bar(degrees)), object(still)};
    plan = plan ? MorphPlan(objects, *plan) : MorphPlan(objects);
    const double direction = directionOf(plan->frame(at(0.5)).surface);
    if (degrees > 10) {
      EXPECT_NEAR(between(direction, before), 5, 1) << degrees << " degrees";
    }
    EXPECT_NEAR(between(direction, 0.5 * degrees), 0, 1) << degrees << " degrees";
    before = direction;
  }
  // A new plan takes the shorter turn: a bar turned by 100 degrees looks like one turned by -80.
  const MorphPlan anew({object(bar(100)), object(still)});
  EXPECT_NEAR(directionOf(anew.frame(at(0.5)).surface), -40, 1);
}

TEST(Sequence, StillObjectsKeepTheirPlan) {
  const MorphPlan next({object(bar(0)), object(stillBar()->deepCopy())}, firstPlan());
  EXPECT_EQ(sentencesOf(next.notes()), sentencesOf(firstPlan().notes()));
  for (double t : {0.3, 0.8})
    EXPECT_TRUE(sameValues(*firstPlan().frame(at(t)).surface, *next.frame(at(t)).surface)) << "t " << t;
}

TEST(Sequence, SameForAnyThreadCount) {
  const std::vector<Object> objects{object(bar(8)), object(stillBar())};
  firstPlan();
  FloatGrid::Ptr one;
  for (int threads : {1, 4})
    withThreads(size_t(threads), [&] {
      const FloatGrid::Ptr frame = MorphPlan(objects, firstPlan()).frame(at(0.5)).surface;
      if (!one) one = frame;
      EXPECT_TRUE(sameValues(*one, *frame)) << threads << " threads";
    });
}

bool plannedAnew(const MorphPlan& plan) {
  const Notes notes = plan.notes();
  return std::any_of(notes.begin(), notes.end(),
                     [](const Note& n) { return n.code == "sequence.planned-anew"; });
}

TEST(Sequence, CutsAndNewEqualsArePlannedAnew) {
  const FloatGrid::Ptr a = bar(0);
  EXPECT_FALSE(plannedAnew(MorphPlan({object(bar(8)), object(stillBar())}, firstPlan())));
  EXPECT_TRUE(plannedAnew(MorphPlan({object(bar(90)), object(stillBar())}, firstPlan()))) << "a cut";
  const MorphPlan equal({object(a), object(a)}, firstPlan());
  EXPECT_TRUE(plannedAnew(equal)) << "equal now";
  EXPECT_TRUE(sameValues(*equal.frame(at(0.5)).surface, *a));
  EXPECT_TRUE(plannedAnew(MorphPlan({object(a), object(stillBar())}, equal))) << "not equal any more";
  EXPECT_THROW(MorphPlan({object(a)}, firstPlan()), InputError);
}

Motion motionOf(const Distance& earlier, const Distance& now, const Vec3d& offset = {0, 0, 0},
                double half = 1.3) {
  const DistanceField a(shapes::levelSet(earlier, shapes::cube({0, 0, 0}, 1.3), kVoxel));
  const DistanceField b(shapes::levelSet(now, shapes::cube(offset, half), kVoxel));
  return trackMotion(a, b, Align::kAuto);
}

double degreesOf(const Mat3d& rotation) { return rotationVector(rotation).length() * 180 / kPi; }

TEST(Track, FollowsAMovedTurnedAndScaledBody) {
  const Mat3d turn = rotationFromVector(Vec3d(1, 2, 3).unit() * (15 * kPi / 180));
  const Vec3d offset(0.7, -1.3, 0.4);
  for (const Distance& shape : {shapes::box(kBar, 0.05), bumpy()}) {
    const Motion m = motionOf(shape, shapes::placed(shape, turn, offset, 1.1), offset, 1.5);
    // A tenth of a voxel at the body's far end, one unit away.
    const double tenth = 0.1 * kVoxel;
    EXPECT_LE(degreesOf(m.rotation * turn.transpose()), tenth * 180 / kPi);
    EXPECT_NEAR(m.scale, 1.1, tenth);
    EXPECT_LE((m(Vec3d(0, 0, 0)) - offset).length(), 2 * tenth);
  }
}

TEST(Track, RoundBodiesDoNotTurn) {
  // Where the surfaces do not determine a turn it must be below 0.1 degrees, so below 10 in 100 frames.
  EXPECT_LE(
      degreesOf(motionOf(shapes::sphere({0, 0, 0}, 0.8), shapes::sphere({0.01, 0.02, 0}, 0.83)).rotation),
      0.1);
  EXPECT_LE(degreesOf(motionOf(ellipsoid({0.9, 0.7, 0.7}), ellipsoid({0.87, 0.73, 0.7})).rotation), 0.1);
  EXPECT_LE(degreesOf(motionOf(ellipsoid({0.81, 0.79, 0.6}), ellipsoid({0.79, 0.81, 0.6})).rotation), 0.1);
  // A body of revolution does not turn about its axis while it is tilted.
  const Mat3d tilt = rotationFromVector({0, 0, 10 * kPi / 180});
  const Motion m =
      motionOf(ellipsoid({0.9, 0.5, 0.5}), shapes::placed(ellipsoid({0.9, 0.5, 0.5}), tilt, {0, 0, 0}));
  EXPECT_LE(degreesOf(m.rotation * tilt.transpose()), 0.2);
}

}  // namespace
}  // namespace slicemorph

#include "tools/job/key_times.h"

#include "engine/measure/measure.h"
#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"
#include "tools/job/input_names.h"
#include "tools/job/option_values.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace slicemorph {
namespace {

const std::vector<std::string> kInputs = {"shapes/fish.ply", "b.vdb:density", "smoke.####.vdb"};

std::string messageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

void expectSays(const std::function<void()>& call, const std::vector<std::string>& texts) {
  const std::string message = messageOf(call);
  for (const std::string& text : texts)
    EXPECT_NE(message.find(text), std::string::npos) << message << "\nlacks " << text;
}

double sumOf(const Weights& weights) { return std::accumulate(weights.begin(), weights.end(), 0.0); }

/// Change of the weights around a time, from its left (-1) or right (1) side, by second order differences.
Weights measuredSlope(const WeightCourse& course, double t, int side) {
  const double h = 1e-5 * side;
  const Weights now = weightsAt(course, t), one = weightsAt(course, t + h),
                two = weightsAt(course, t + 2 * h);
  Weights slope(now.size());
  for (size_t k = 0; k < now.size(); ++k) slope[k] = (4 * one[k] - 3 * now[k] - two[k]) / (2 * h);
  return slope;
}

void expectNear(const Weights& a, const Weights& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], tolerance) << "weight " << k;
}

WeightCourse courseOfText(const std::string& keys, Timing timing, const std::string& ease = "linear") {
  return courseOf(parseKeys("--keys", keys, kInputs), timing, parseEasing("--ease", ease));
}

TEST(InputNames, AreFoundInEveryWay) {
  for (const std::string name : {"shapes/fish.ply", "fish", "1", "a"})
    EXPECT_EQ(inputNamed(name, kInputs), 0u) << name;
  for (const std::string name : {"b.vdb:density", "b", "2"}) EXPECT_EQ(inputNamed(name, kInputs), 1u) << name;
  for (const std::string name : {"smoke.####.vdb", "smoke", "3", "c"})
    EXPECT_EQ(inputNamed(name, kInputs), 2u) << name;
  EXPECT_EQ(stemOfInput("x/scan.nii.gz"), "scan");
  EXPECT_EQ(stemOfInput("x/a.v2.ply"), "a.v2");
}

TEST(InputNames, StemsComeBeforeLetters) {
  const std::vector<std::string> inputs = {"b.ply", "c.ply", "a.ply"};
  EXPECT_EQ(inputNamed("a", inputs), 2u);
  EXPECT_EQ(inputNamed("b", inputs), 0u);
  EXPECT_EQ(nameOfInput(2, inputs), "a");
}

TEST(InputNames, UnknownAndAmbiguousOnesAreRefused) {
  expectSays([] { inputNamed("d", kInputs); },
             {"'d' is no input", "1 'fish' (shapes/fish.ply)", "3 'smoke'"});
  const std::vector<std::string> twins = {"x/ball.ply", "y/ball.ply", "2.ply"};
  expectSays([&] { inputNamed("ball", twins); }, {"more than one", "x/ball.ply", "y/ball.ply", "number"});
  expectSays([&] { inputNamed("2", twins); }, {"more than one"});
  EXPECT_EQ(inputNamed("y/ball.ply", twins), 1u);
  EXPECT_EQ(nameOfInput(0, twins), "1");
}

TEST(Keys, AreParsed) {
  const auto keys = parseKeys("--keys", "a@0, b@.5 fish@0.75,smoke@1", kInputs);
  ASSERT_EQ(keys.size(), 4u);
  EXPECT_EQ(keys[1].at, 0.5);
  EXPECT_EQ(keys[1].weights, (Weights{0, 1, 0}));
  EXPECT_EQ(keys[2].weights, (Weights{1, 0, 0}));
  EXPECT_EQ(noteOfUnused(keys, kInputs), "");
  EXPECT_NE(noteOfUnused(parseKeys("--keys", "a@0 c@1", kInputs), kInputs).find("b.vdb:density"),
            std::string::npos);
}

TEST(Keys, BadOnesAreRefused) {
  const auto parse = [](const std::string& text) { return [=] { parseKeys("--keys", text, kInputs); }; };
  expectSays(parse("a@0 b"), {"--keys a@0 b", "'b' is no key", "INPUT@TIME"});
  expectSays(parse("a@0 b@half"), {"'b@half'"});
  expectSays(parse("a@0 b@1.5"), {"1.5", "0 to 1"});
  expectSays(parse("a@0 b@nan"), {"0 to 1"});
  expectSays(parse("a@0 b@0.5 c@0.5"), {"'c@0.5'", "rise"});
  expectSays(parse("a@0 fox@1"), {"'fox' is no input", "fish"});
  expectSays(parse("@0"), {"is no key"});
  expectSays(parse(" "), {"no key"});
}

TEST(Course, WithoutKeysIsTheChain) {
  const WeightCourse course = courseOf(evenKeys(3), Timing::kLinear, {});
  EXPECT_EQ(weightsAt(course, 0), (Weights{1, 0, 0}));
  EXPECT_EQ(weightsAt(course, 0.25), (Weights{0.5, 0.5, 0}));
  EXPECT_EQ(weightsAt(course, 0.5), (Weights{0, 1, 0}));
  EXPECT_EQ(weightsAt(course, 1), (Weights{0, 0, 1}));
  EXPECT_EQ(slopeAt(course, 0.5), (Weights{0, -2, 2}));
  EXPECT_EQ(slopeAt(course, 1), (Weights{0, -2, 2}));
}

TEST(Course, StaysBeforeTheFirstKeyAndAfterTheLast) {
  for (const Timing timing : {Timing::kLinear, Timing::kSmoothstep, Timing::kCatmullRom}) {
    const WeightCourse course = courseOfText("a@0.25 b@0.5 c@0.75", timing);
    EXPECT_EQ(weightsAt(course, 0.1), (Weights{1, 0, 0}));
    EXPECT_EQ(weightsAt(course, 0.9), (Weights{0, 0, 1}));
    EXPECT_EQ(slopeAt(course, 0.1), (Weights{0, 0, 0}));
    EXPECT_EQ(slopeAt(course, 0.9), (Weights{0, 0, 0}));
  }
}

TEST(Course, KeysAreMetExactly) {
  for (const Timing timing : {Timing::kLinear, Timing::kSmoothstep, Timing::kCatmullRom}) {
    const WeightCourse course = courseOfText("a@0 b@0.3 a@0.6 c@1", timing);
    for (const WeightKey& key : course.keys) EXPECT_EQ(weightsAt(course, key.at), key.weights);
  }
  // An easing that is half-way at half the time.
  EXPECT_EQ(weightsAt(courseOfText("a@0 b@0.5 c@1", Timing::kLinear, "in-out"), 0.5), (Weights{0, 1, 0}));
}

TEST(Course, WeightsSumToOneAndSlopesAreTheirs) {
  for (const Timing timing : {Timing::kLinear, Timing::kSmoothstep, Timing::kCatmullRom})
    for (const std::string ease : {"linear", "in", "out", "in-out", "0.1,0.9,0.4,0.2", "0.3,-0.5,0.7,1.5"}) {
      const WeightCourse course = courseOfText("a@0 b@0.2 a@0.55 c@0.8", timing, ease);
      for (int i = 0; i < 97; ++i) {
        const double t = (i + 0.37) / 98;
        EXPECT_NEAR(sumOf(weightsAt(course, t)), 1, 1e-12);
        EXPECT_NEAR(sumOf(slopeAt(course, t)), 0, 1e-11);
        expectNear(slopeAt(course, t), measuredSlope(course, t, 1), 1e-3);
      }
    }
}

TEST(Course, SmoothstepStopsAtKeys) {
  const WeightCourse course = courseOfText("a@0 b@0.5 c@1", Timing::kSmoothstep);
  for (const double t : {0.0, 0.5, 1.0}) EXPECT_EQ(slopeAt(course, t), (Weights{0, 0, 0}));
  expectNear(weightsAt(course, 0.25), {0.5, 0.5, 0}, 1e-15);
  expectNear(weightsAt(course, 0.125), {1 - 0.15625, 0.15625, 0}, 1e-15);
}

TEST(Course, CatmullRomOfTwoKeysIsLinear) {
  const WeightCourse course = courseOf(evenKeys(2), Timing::kCatmullRom, {});
  for (const double t : {0.0, 0.1, 0.5, 0.77, 1.0}) {
    expectNear(weightsAt(course, t), {1 - t, t}, 1e-15);
    expectNear(slopeAt(course, t), {-1, 1}, 1e-15);
  }
}

TEST(Course, CatmullRomHasTheParabolasTangents) {
  const WeightCourse course = courseOfText("a@0 b@0.4 c@1", Timing::kCatmullRom);
  // Through (0, 0), (0.4, 1), (1, 0): x (1 - x) / 0.24, whose slope there is (1 - 0.8) / 0.24.
  EXPECT_NEAR(slopeAt(course, 0.4)[1], 0.2 / 0.24, 1e-12);
}

TEST(Course, CatmullRomIsSmoothAtKeys) {
  // The last one is so uneven that tangents have to be shortened; in the one before it weights are constant
  // for a while.
  for (const std::string keys :
       {"a@0 b@0.5 c@1", "a@0 b@0.3 c@0.4 a@0.9", "a@0.1 b@0.3 b@0.6 c@1", "a@0 b@0.01 c@0.02 a@0.99 b@1"}) {
    const WeightCourse course = courseOfText(keys, Timing::kCatmullRom);
    for (const WeightKey& key : course.keys) {
      if (key.at == 0 || key.at == 1) continue;
      expectNear(measuredSlope(course, key.at, -1), measuredSlope(course, key.at, 1), 0.02);
    }
    double least = 0;
    for (int i = 0; i <= 5000; ++i)
      for (const double w : weightsAt(course, i / 5000.0)) least = std::min(least, w);
    EXPECT_GE(least, kLeastWeight) << keys;
  }
}

TEST(Course, TangentsThatLeadTooFarAreShortened) {
  // The parabola's tangent at the second key, -9 for the first weight, would lead it to -9 * 0.9 * 4/27.
  const WeightCourse course = courseOfText("a@0 b@0.1 c@1", Timing::kCatmullRom);
  double least = 0;
  for (int i = 0; i <= 10000; ++i) least = std::min(least, weightsAt(course, i / 10000.0)[0]);
  EXPECT_GE(least, kLeastWeight);
  // At most one step shorter than needed.
  EXPECT_LT(least, 0.9 * kLeastWeight);
  expectNear(measuredSlope(course, 0.1, -1), measuredSlope(course, 0.1, 1), 0.01);
}

TEST(Course, WeightsThatStayDoSo) {
  const WeightCourse course = courseOfText("a@0 b@0.3 b@0.6 c@1", Timing::kCatmullRom);
  for (const double t : {0.3, 0.4, 0.55}) EXPECT_EQ(weightsAt(course, t), (Weights{0, 1, 0}));
}

TEST(Easing, IsCss) {
  EXPECT_EQ(easedTime(parseEasing("--ease", "linear"), 0.3), 0.3);
  // Values of CSS's cubic-bezier by its definition, solved by hand with x(s) = t.
  for (const std::string name : {"in", "out", "in-out", "0.25,0.1,0.25,1"}) {
    const Easing e = parseEasing("--ease", name);
    EXPECT_EQ(easedTime(e, 0), 0);
    EXPECT_EQ(easedTime(e, 1), 1);
    for (const double s : {0.1, 0.35, 0.5, 0.8}) {
      const double a = 3 * s * (1 - s) * (1 - s), b = 3 * s * s * (1 - s), c = s * s * s;
      EXPECT_NEAR(easedTime(e, a * e.x1 + b * e.x2 + c), a * e.y1 + b * e.y2 + c, 1e-12) << name;
    }
  }
  EXPECT_NEAR(easedTime(parseEasing("--ease", "in-out"), 0.5), 0.5, 1e-12);
}

TEST(Easing, SpeedsAtTheEnds) {
  EXPECT_EQ(easedSpeed(parseEasing("--ease", "in"), 0), 0);
  EXPECT_NEAR(easedSpeed(parseEasing("--ease", "out"), 0), 1 / 0.58, 1e-12);
  EXPECT_NEAR(easedSpeed(parseEasing("--ease", "in"), 1), 1 / 0.58, 1e-12);
  EXPECT_EQ(easedSpeed(parseEasing("--ease", "in-out"), 1), 0);
  // The curve is vertical at its start and in its middle: speeds must stay finite.
  EXPECT_TRUE(std::isfinite(easedSpeed(parseEasing("--ease", "0,1,1,1"), 0)));
  EXPECT_TRUE(std::isfinite(easedSpeed(parseEasing("--ease", "1,0,0,1"), 0.5)));
}

TEST(Easing, BadOnesAreRefused) {
  const auto parse = [](const std::string& text) { return [=] { parseEasing("--ease", text); }; };
  expectSays(parse("bounce"), {"--ease bounce", "linear, in, out, in-out"});
  expectSays(parse("0.1,0.2,0.3"), {"four numbers"});
  expectSays(parse("-0.1,0,0.3,1"), {"-0.1", "0 to 1"});
}

TEST(GivenWeights, AreNormalisedOrRefused) {
  EXPECT_EQ(checkWeights("w", {0.25, 0.75}, 2).note, "");
  const CheckedWeights checked = checkWeights("--weights 1,3", {1, 3}, 2);
  EXPECT_EQ(checked.weights, (Weights{0.25, 0.75}));
  EXPECT_EQ(checked.note, "--weights 1,3 sum to 4: taken as 0.25,0.75");
  EXPECT_EQ(checkWeights("w", checkWeights("w", {1, 1, 1}, 3).weights, 3).note, "");
  expectSays([] { checkWeights("--weights 0,0", {0, 0}, 2); }, {"--weights 0,0", "all 0"});
  expectSays([] { checkWeights("--weights -1,2", {-1, 2}, 2); }, {"-1 is negative", "0 or more"});
  expectSays([] { checkWeights("w", {NAN, 2}, 2); }, {"not finite"});
  expectSays([] { checkWeights("w", {1, 2, 3}, 2); }, {"3 numbers for 2 inputs"});
}

TEST(Numbers, AreAsShortAsTheyCanBe) {
  EXPECT_EQ(formatExactly(0.1), "0.1");
  EXPECT_EQ(formatExactly(24), "24");
  for (const double value : {1.0 / 3, 0.1 + 0.2, 1e-300, 123456789.123456789})
    EXPECT_EQ(std::stod(formatExactly(value)), value);
}

/// A ball becomes a long box, which becomes a leaning one: the morph passes exactly through the middle one,
/// and with Catmull-Rom without a jump of speed. Speeds are measured as symmetric differences of frames;
/// between frames 1/96 apart the course's own acceleration changes them by 2 % where weights reach a key a
/// third of a unit of time away.
TEST(Keyed, PassesThroughTheMiddleObjectWithoutAJump) {
  const openvdb::BBoxd box = shapes::cube({0, 0, 0}, 1.6);
  const double h = 2.4 / 96;
  const Mat3d lean(0.8, -0.6, 0., 0.6, 0.8, 0., 0., 0., 1.);
  const std::vector<Object> objects{
      {"a", shapes::levelSet(shapes::sphere({-0.2, 0, 0}, 0.9), box, h)},
      {"b", shapes::levelSet(shapes::box({1.2, 0.5, 0.6}, 0.2), box, h)},
      {"c", shapes::levelSet(shapes::placed(shapes::box({1.1, 0.7, 0.4}, 0.3), lean, {0.7, 0, 0}), box, h)}};
  const MorphPlan plan(objects);
  const std::vector<WeightKey> keys{{0, {1, 0, 0}}, {0.5, {0, 1, 0}}, {1, {0, 0, 1}}};
  const auto jumpOf = [&](Timing timing) {
    const WeightCourse course = courseOf(keys, timing, {});
    EXPECT_TRUE(sameValues(*plan.frame(weightsAt(course, 0.5)).surface, *objects[1].levelSet));
    std::vector<FloatGrid::Ptr> frames;
    for (int i = -3; i <= 3; ++i) frames.push_back(plan.frame(weightsAt(course, 0.5 + i / 96.0)).surface);
    std::vector<double> speed;
    for (size_t i = 0; i + 1 < frames.size(); ++i)
      speed.push_back(overlap(*frames[i], *frames[i + 1]).symmetricDifference);
    double most = 0;
    for (size_t i = 0; i + 1 < speed.size(); ++i)
      most = std::max(most, std::abs(speed[i + 1] / speed[i] - 1));
    for (double s : speed) std::printf("  %.4f", s);
    std::printf("  largest jump %.1f %%\n", 100 * most);
    return most;
  };
  EXPECT_LE(jumpOf(Timing::kCatmullRom), 0.1);
  EXPECT_GE(jumpOf(Timing::kLinear), 0.1) << "the shapes do not tell a jump of speed";
}

}  // namespace
}  // namespace slicemorph

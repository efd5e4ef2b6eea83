// Which way round the second object lies, where the answer is known.
#include "engine/match/choose_frames.h"

#include "tests/support/all_tests.h"
#include "tests/support/fields.h"
#include "tests/support/quadruped.h"
#include "tests/support/random_rotation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace slicemorph {
namespace {

constexpr double kFrameVoxel = 0.03;
/// Turns are climbed by steps down to .03 radians, and samples of a turned shape lie elsewhere in their cells.
constexpr double kTolerance = 0.05;

/// An animal about its middle, z up, turned and moved.
std::shared_ptr<const DistanceField> animal(const Mat3d& turn,
                                            const shapes::Quadruped::Swing& swing = {0, 0, 0, 0}) {
  const Vec3d middle(0.06, 0, 0.35), offset(3, -2, 1);
  const shapes::Distance own = shapes::quadruped(swing);
  const shapes::Distance centred = [=](const Vec3d& p) { return own(p + middle); };
  return shapes::fieldOf(shapes::placed(centred, turn, offset), {offset - Vec3d(1.3), offset + Vec3d(1.3)},
                         kFrameVoxel);
}

MorphOptions straight(const Vec3d& up) {
  MorphOptions options;
  options.up = up, options.spine = SpineKind::kStraight;
  return options;
}

/// From the first object's directions to the second's.
Mat3d turnOf(const Frames& frames) { return frames.charts[1].axes * frames.charts[0].axes.transpose(); }

double apart(const Mat3d& a, const Mat3d& b) { return rotationVector(a.transpose() * b).length(); }

/// Whether a warning says that another way round fits hardly worse.
bool doubts(const Frames& frames) {
  return std::any_of(frames.notes.begin(), frames.notes.end(), [](const Note& n) {
    return n.code == "frame.unsure" && n.severity == Severity::kWarning;
  });
}

const std::vector<std::string> kNames{"first", "second"};
const Vec3d kZ(0, 0, 1);

TEST(ChooseFrames, FindsATurnAboutTheUpDirection) {
  const auto standing = animal(Mat3d::identity());
  for (double degrees : {40.0, 95.0, 180.0, 250.0}) {
    SCOPED_TRACE(degrees);
    const Mat3d turn = rotationFromVector(degrees * M_PI / 180 * kZ);
    const auto turned = animal(turn);
    const Frames frames = chooseFrames({standing, turned}, kNames, straight(kZ), {});
    EXPECT_LT(apart(turnOf(frames), turn), kTolerance);
    EXPECT_FALSE(doubts(frames));
    EXPECT_LT(apart(turnOf(chooseFrames({turned, standing}, kNames, straight(kZ), {})), turn.transpose()),
              kTolerance);
  }
}

TEST(ChooseFrames, FindsAnyTurnWhereNothingIsUp) {
  const auto standing = animal(Mat3d::identity());
  for (const Vec3d& vector : {Vec3d(0.5, -1.2, 0.8), Vec3d(-2.0, 0.4, 1.1), Vec3d(1.0, 2.5, -0.3)}) {
    SCOPED_TRACE(::testing::Message() << vector);
    const Mat3d turn = rotationFromVector(vector);
    EXPECT_LT(apart(turnOf(chooseFrames({standing, animal(turn)}, kNames, straight(Vec3d(0.0)), {})), turn),
              kTolerance);
  }
}

/// A standing animal and a running one, both turned at random, are laid on each other as when neither is turned. Turns
/// that differ by less than 20 degrees are one way round (kSameTurn in engine/frame/align.cpp).
TEST(ChooseFrames, FindsTheSameHoweverBothObjectsLie) {
  constexpr double kSameWay = 0.35;
  const shapes::Quadruped::Swing running{35, -20, 25, -35};
  std::mt19937 random(3);
  for (int i = 0; i < (allTests() ? 20 : 4); ++i) {
    SCOPED_TRACE(i);
    const Mat3d first = randomRotation(random), second = randomRotation(random);
    Fields pair{animal(first), animal(second, running)};
    const Mat3d found = turnOf(chooseFrames(pair, kNames, straight(Vec3d(0.0)), {}));
    EXPECT_LT(apart(second.transpose() * found * first, Mat3d::identity()), kSameWay);
    std::swap(pair[0], pair[1]);
    const Mat3d back = turnOf(chooseFrames(pair, kNames, straight(Vec3d(0.0)), {}));
    EXPECT_LT(apart(back, found.transpose()), kSameWay);
  }
}

TEST(ChooseFrames, TurnsNothingThatIsToKeepItsDirections) {
  const Mat3d turn = rotationFromVector(2.0 * kZ);
  MorphOptions options = straight(kZ);
  options.align = Align::kNone;
  EXPECT_LT(apart(turnOf(chooseFrames({animal(Mat3d::identity()), animal(turn)}, kNames, options, {})),
                  Mat3d::identity()),
            1e-12);
}

/// Balls look the same from everywhere: they keep their directions, and the note says so of the object it is about.
TEST(ChooseFrames, TiesKeepDirections) {
  Fields balls;
  for (double radius : {1.0, 0.6})
    balls.push_back(
        shapes::fieldOf(shapes::sphere(Vec3d(0.0), radius), {Vec3d(-1.0), Vec3d(1.0)}, kFrameVoxel));
  const Frames frames = chooseFrames(balls, kNames, straight(kZ), {});
  EXPECT_LT(apart(turnOf(frames), Mat3d::identity()), 1e-12);
  ASSERT_FALSE(frames.notes.empty());
  EXPECT_EQ(frames.notes[0].code, "frame.kept");
  EXPECT_EQ(frames.notes[0].about, "second");
  // Other ways round are no doubt where they look the same.
  EXPECT_FALSE(doubts(frames));
  for (const TurnChoice& choice : frames.choices) EXPECT_LT(choice.margin, 0);
}

/// What has a head at one end and a tail at the other fits what has heads at both ends either way.
TEST(ChooseFrames, SaysWhereItIsNotSure) {
  using shapes::capsule;
  const auto beast = [](bool secondHead) {
    std::vector<shapes::Distance> parts{
        capsule({-0.8, 0, 0}, {0.8, 0, 0}, 0.3), capsule({0.8, 0, 0.1}, {1.2, 0, 0.4}, 0.22),
        capsule({0.3, 0, 0}, {0.3, 0, -0.8}, 0.12), capsule({-0.3, 0, 0}, {-0.3, 0, -0.8}, 0.12)};
    parts.push_back(secondHead ? capsule({-0.8, 0, 0.1}, {-1.2, 0, 0.4}, 0.22)
                               : capsule({-0.8, 0, 0.1}, {-1.5, 0, 0.1}, 0.08));
    return shapes::fieldOf(shapes::joined(parts), {Vec3d(-1.8), Vec3d(1.8)}, kFrameVoxel);
  };
  const Frames frames = chooseFrames({beast(false), beast(true)}, kNames, straight(kZ), {});
  ASSERT_EQ(frames.choices.size(), 1u);
  EXPECT_GE(frames.choices[0].margin, 0);
  EXPECT_TRUE(doubts(frames));
}

}  // namespace
}  // namespace slicemorph

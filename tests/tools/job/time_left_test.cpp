#include "tools/job/time_left.h"

#include "tools/job/work_steps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace slicemorph {
namespace {

/// A step of a made-up job: its stage, its true seconds, and the seconds that the job expects.
struct Step {
  std::string stage;
  double seconds, expected;
};

/// The worst ratio of the time that is told to be left to the true one, or its inverse, from a share of the job's time until
/// a twentieth is left, looked at after every step and within it.
double worstFactor(const std::vector<Step>& steps, double fromShare) {
  WorkSteps work;
  double total = 0;
  for (const Step& step : steps) work.add(step.expected), total += step.seconds;
  TimeLeft left;
  double now = 0, worst = 1;
  const auto look = [&](double at) {
    const double truly = total - at;
    if (at < fromShare * total || truly < 0.05 * total) return;
    const std::optional<double> told = left.at(at);
    if (told) worst = std::max({worst, *told / truly, truly / std::max(*told, 1e-9)});
  };
  for (size_t i = 0; i < steps.size(); ++i) {
    left.report(steps[i].stage, work.from(i), now);
    look(now), look(now + steps[i].seconds / 2);
    now += steps[i].seconds;
    left.report(steps[i].stage, work.to(i), now);
    look(now);
  }
  return worst;
}

std::vector<Step> stillJob(double planned, double expected, int frames) {
  std::vector<Step> steps;
  for (int i = 0; i < 10; ++i) steps.push_back({"match", planned / 10, expected / 10});
  for (int i = 0; i < frames; ++i) steps.push_back({"making frames", 1, 1});
  return steps;
}

TEST(TimeLeft, NothingIsToldAtFirst) {
  TimeLeft left;
  EXPECT_FALSE(left.at(0));
  left.report("reading", 0, 0);
  left.report("reading", 0.5, 0.01);
  EXPECT_FALSE(left.at(0.02));
}

TEST(TimeLeft, EvenWorkIsToldExactly) { EXPECT_NEAR(worstFactor(stillJob(8, 8, 24), 0), 1, 1e-9); }

TEST(TimeLeft, FractionsNeverGoBack) {
  TimeLeft left;
  left.report("a", 0.5, 2);
  left.report("b", 0.2, 3);
  EXPECT_EQ(left.fraction(), 0.5);
  left.report("b", 7, 4);
  EXPECT_EQ(left.fraction(), 1);
}

TEST(TimeLeft, CountsDownBetweenReports) {
  TimeLeft left;
  left.report("a", 0, 0);
  left.report("a", 0.5, 10);
  ASSERT_TRUE(left.at(10));
  EXPECT_NEAR(*left.at(10), 10, 1e-9);
  EXPECT_NEAR(*left.at(13), 7, 1e-9);
  EXPECT_FALSE(left.at(21));  // later than was thought: nothing is told rather than a wrong time
}

// Planning that takes three times or a third of what its share in the job says. While nothing else has been done, the time is
// wrong by as much (and, half a frame later, where both have become half a frame less, by 71.5 / 23.5); once two frames are
// made, by less than 1.5.
TEST(TimeLeft, FramesTellTheTruthAboutFrames) {
  for (const double planned : {24.0, 8.0, 8.0 / 3}) {
    const std::vector<Step> steps = stillJob(planned, 8, 24);
    const double total = planned + 24;
    EXPECT_LT(worstFactor(steps, std::max(0.25, (planned + 2) / total)), 1.5) << planned;
    EXPECT_LT(worstFactor(steps, 0.25), 3.05) << planned;
  }
}

// Sequences plan each frame from the one before, the first from nothing.
TEST(TimeLeft, SequencesAreToldByTheirTurns) {
  std::vector<Step> steps;
  for (int i = 0; i < 24; ++i) {
    steps.push_back({"match", i == 0 ? 12.0 : 3.0, i == 0 ? 8 : 1.5});
    steps.push_back({"making frames", 1, 1});
  }
  EXPECT_LT(worstFactor(steps, 0.25), 1.5);
}

TEST(WorkSteps, SharesAreThoseOfTheCosts) {
  WorkSteps steps;
  for (const double cost : {1.0, 0.0, 3.0}) steps.add(cost);
  EXPECT_EQ(steps.from(0), 0);
  EXPECT_EQ(steps.to(0), 0.25);
  EXPECT_EQ(steps.from(2), 0.25);
  EXPECT_EQ(steps.to(2), 1);
  WorkSteps nothing;
  nothing.add(0);
  EXPECT_EQ(nothing.from(0), 0);
  EXPECT_EQ(nothing.to(0), 1);
}

}  // namespace
}  // namespace slicemorph

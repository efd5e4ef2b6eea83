// Plans by the decisions of an earlier plan: the same frames, values and velocities; what is damaged is refused.
#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace slicemorph {
namespace {

constexpr double kVoxel = 2.0 / 40;

Object ball(double radius) {
  return {"ball",
          shapes::levelSet(shapes::sphere({0.1, 0, 0}, radius), shapes::cube({0, 0, 0}, 1.2), kVoxel)};
}

Object bar(const Vec3d& half) {
  return {"bar", shapes::levelSet(shapes::box(half, 0.05), shapes::cube({0, 0, 0}, 1.2), kVoxel)};
}

void expectTheSame(const MorphPlan& a, const MorphPlan& b, const Weights& weights, const Weights& rate) {
  const InBetween x = a.frame(weights), y = b.frame(weights);
  EXPECT_TRUE(sameValues(*x.surface, *y.surface));
  EXPECT_EQ(x.foldShare, y.foldShare);
  const auto u = a.pullback(weights).velocity(*x.surface, rate),
             v = b.pullback(weights).velocity(*y.surface, rate);
  size_t other = u->activeVoxelCount() != v->activeVoxelCount();
  for (auto it = u->cbeginValueOn(); it; ++it) other += *it != v->tree().getValue(it.getCoord());
  EXPECT_EQ(other, 0u);
  EXPECT_EQ(sentencesOf(a.notes()), sentencesOf(b.notes()));
  EXPECT_EQ(a.overlap(), b.overlap());
  EXPECT_EQ(a.decisions(), b.decisions());
}

TEST(PlanDecisions, FramesAreTheSame) {
  const std::vector<Object> objects{ball(0.8), bar({1, 0.4, 0.3})};
  const MorphPlan plan(objects);
  const std::string decisions = plan.decisions();
  std::printf("  %.2f MB\n", double(decisions.size()) * 1e-6);
  expectTheSame(plan, MorphPlan::decidedBefore(objects, {}, decisions), {0.7, 0.3}, {-1, 1});
}

/// More than two objects, of which two are equal, and a region with weights of its own.
TEST(PlanDecisions, AlsoOfManyWithARegion) {
  const std::vector<Object> objects{ball(0.8), bar({1, 0.4, 0.3}), ball(0.8)};
  MorphOptions options;
  Region region;
  region.name = "end", region.kind = Region::Kind::kSpine;
  region.from = 0.6, region.to = 1, region.border = 0.3, region.weights = {0, 1, 0};
  options.regions = {region};
  const MorphPlan plan(objects, options);
  expectTheSame(plan, MorphPlan::decidedBefore(objects, options, plan.decisions()), {0.5, 0.3, 0.2},
                {-1, 1, 0});
}

TEST(PlanDecisions, AlongCurvedSpines) {
  MorphOptions options;
  options.spine = SpineKind::kCurved;
  const std::vector<Object> objects{bar({1, 0.16, 0.1}), bar({1.1, 0.12, 0.14})};
  const MorphPlan plan(objects, options);
  expectTheSame(plan, MorphPlan::decidedBefore(objects, options, plan.decisions()), {0.4, 0.6}, {-1, 1});
}

TEST(PlanDecisions, OfOneShapeAreTakenToo) {
  const std::vector<Object> objects{ball(0.8), ball(0.8)};
  const MorphPlan plan(objects);
  const MorphPlan again = MorphPlan::decidedBefore(objects, {}, plan.decisions());
  EXPECT_TRUE(sameValues(*again.frame({0.5, 0.5}).surface, *objects[0].levelSet));
}

TEST(PlanDecisions, OfOtherObjectsAreRefused) {
  const std::string decisions = MorphPlan({ball(0.8), bar({1, 0.4, 0.3})}).decisions();
  for (const std::vector<Object>& others :
       {std::vector<Object>{ball(0.8), bar({1, 0.4, 0.35})}, std::vector<Object>{ball(0.8), ball(0.8)},
        std::vector<Object>{bar({1, 0.4, 0.3}), ball(0.8)},
        std::vector<Object>{ball(0.8), bar({1, 0.4, 0.3}), ball(0.7)}}) {
    try {
      MorphPlan::decidedBefore(others, {}, decisions);
      ADD_FAILURE() << "decisions on other objects were taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("other objects"), std::string::npos) << error.what();
    }
  }
}

/// Cut anywhere, or with bytes behind; a few of the cuts within the map are representative of all.
TEST(PlanDecisions, DamagedOnesAreRefused) {
  const std::vector<Object> objects{ball(0.8), bar({1, 0.4, 0.3})};
  const std::string whole = MorphPlan(objects).decisions();
  std::vector<size_t> cuts;
  for (size_t size = 0; size < 3000; size += 97) cuts.push_back(size);
  for (size_t size = 3000; size < whole.size(); size += whole.size() / 7) cuts.push_back(size);
  cuts.push_back(whole.size() - 1);
  for (size_t size : cuts)
    EXPECT_THROW(MorphPlan::decidedBefore(objects, {}, whole.substr(0, size)), InputError) << size;
  EXPECT_THROW(MorphPlan::decidedBefore(objects, {}, whole + "x"), InputError);
}

TEST(PlanDecisions, CannotBeFollowed) {
  const std::vector<Object> objects{ball(0.8), bar({1, 0.4, 0.3})};
  const MorphPlan again = MorphPlan::decidedBefore(objects, {}, MorphPlan(objects).decisions());
  EXPECT_THROW(MorphPlan({ball(0.82), bar({1, 0.4, 0.3})}, again), InputError);
}

}  // namespace
}  // namespace slicemorph

// More than two objects, in proportions that may differ from part to part: 128 voxels along the longest side
// where a closed form asks for a share of a voxel, half as many where results are compared with each other.
#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/all_tests.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>

namespace slicemorph {
namespace {

using shapes::Distance;

Object object(const std::string& name, const Distance& distance, const openvdb::BBoxd& box, double h) {
  return {name, shapes::levelSet(distance, box, h)};
}

Distance smoothUnion(const Distance& a, const Distance& b, double k) {
  return [=](const Vec3d& p) {
    const double da = a(p), db = b(p), f = std::min(std::max(0.5 + 0.5 * (db - da) / k, 0.0), 1.0);
    return db + (da - db) * f - k * f * (1 - f);
  };
}

/// Four different objects: a ball, a long box, half a ring with a bump, a tilted dumb-bell.
std::vector<Object> fourObjects(int voxels) {
  const double h = 2.4 / voxels;
  const openvdb::BBoxd box = shapes::cube({0, 0, 0}, 1.6);
  const Mat3d lean(0.8, -0.6, 0., 0.6, 0.8, 0., 0., 0., 1.);
  return {object("ball", shapes::sphere({0.1, 0, 0}, 1), box, h),
          object("box", shapes::box({1.2, 0.5, 0.6}, 0.15), box, h),
          object("bump",
                 smoothUnion(shapes::box({1.1, 0.7, 0.4}, 0.3), shapes::sphere({0.3, 0.5, 0.4}, 0.45), 0.3),
                 box, h),
          object("bell",
                 shapes::placed(smoothUnion(smoothUnion(shapes::sphere({-0.7, 0, 0}, 0.45),
                                                        shapes::sphere({0.7, 0, 0}, 0.55), 0.2),
                                            shapes::box({0.8, 0.25, 0.25}, 0.1), 0.2),
                                lean, {0, 0, 0}),
                 box, h)};
}

int resolution() { return allTests() ? 128 : 64; }

/// Made once for all tests that use it.
std::shared_ptr<const MorphPlan> planOfFour() {
  static const auto plan = std::make_shared<MorphPlan>(fourObjects(resolution()));
  return plan;
}

SurfaceDistance distance(const FloatGrid& a, const FloatGrid& b) {
  return surfaceDistance(surfaceOf(a), surfaceOf(b));
}

/// The blend does not depend on the order of the objects: limit 0.1 voxel; in fact it is
/// identical to the last bit.
TEST(Many, OrderDoesNotMatter) {
  const std::vector<Object> objects = fourObjects(resolution());
  const Weights weights{0.4, 0.3, 0.2, 0.1};
  FloatGrid::Ptr first;
  for (const std::array<size_t, 4>& order : {std::array<size_t, 4>{0, 1, 2, 3}, {3, 1, 0, 2}, {2, 3, 1, 0}}) {
    if (first && order[0] == 2 && !allTests()) continue;
    std::vector<Object> permuted;
    Weights own;
    for (size_t k : order) permuted.push_back(objects[k]), own.push_back(weights[k]);
    const std::shared_ptr<const MorphPlan> plan =
        first ? std::make_shared<MorphPlan>(permuted) : planOfFour();
    const FloatGrid::Ptr frame = plan->frame(own).surface;
    const ShapeMeasures m = measureShape(*frame);
    if (!first) {
      first = frame;
      for (const Note& note : plan->notes()) std::printf("  %s\n", note.sentence().c_str());
      std::printf("  %d pieces, genus %d, fold %.4f\n", m.pieces, m.genus, plan->frame(own).foldShare);
      EXPECT_EQ(m.pieces, 1);
      EXPECT_EQ(m.genus, 0);
    }
    EXPECT_TRUE(sameValues(*frame, *first));
  }
}

/// Exactly at unit weights, and continuously next to them.
TEST(Many, UnitWeightsGiveTheObjects) {
  const std::vector<Object> objects = fourObjects(resolution());
  const MorphPlan& plan = *planOfFour();
  for (size_t k = 0; k < objects.size(); ++k) {
    Weights w(objects.size(), 0);
    w[k] = 1;
    // By construction the object's own grid: no resampling at its own voxel size.
    EXPECT_TRUE(sameValues(*plan.frame(w).surface, *objects[k].levelSet)) << objects[k].name;
    // Continuity: a change of the weights by a thousandth moves nothing by more than a tenth of a voxel.
    for (double& x : w) x = 0.999 * x + 0.001 / double(objects.size());
    const SurfaceDistance d = distance(*plan.frame(w).surface, *objects[k].levelSet);
    const double h = objects[k].levelSet->voxelSize()[0];
    std::printf("  %s: %.3f mean, %.3f max voxels\n", objects[k].name.c_str(), d.mean / h, d.max / h);
    EXPECT_LE(d.mean / h, 0.1);
    EXPECT_LE(d.max / h, 1.0);
  }
}

TEST(Many, EqualBlendOfThreeSpheres) {
  std::vector<Object> objects;
  for (double r : {1.0, 2.0, 3.0})
    objects.push_back(
        object("r", shapes::sphere({r, 0, -r}, r), shapes::cube({r, 0, -r}, r + 0.5), 2 * r / 128));
  const FloatGrid::Ptr frame = MorphPlan(objects).frame({1 / 3.0, 1 / 3.0, 1 / 3.0}).surface;
  const double h = frame->voxelSize()[0];
  double most = 0;
  for (const auto& p : surfaceOf(*frame).points)
    most = std::max(most, std::abs((Vec3d(p) - Vec3d(2, 0, -2)).length() - 2));
  std::printf("  radius off by %.3f voxels at most\n", most / h);
  EXPECT_LE(most / h, 0.25);
}

TEST(Many, ThreadsDoNotChangeAValue) {
  std::vector<Object> objects = fourObjects(64);
  objects.pop_back();
  FloatGrid::Ptr first;
  for (size_t threads : {1, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const FloatGrid::Ptr frame = MorphPlan(objects).frame({0.4, 0.3, 0.3}).surface;
    if (!first) first = frame;
    EXPECT_TRUE(sameValues(*frame, *first)) << threads << " threads";
  }
}

/// Half width of a section across x, of a body of revolution.
double radiusAt(const Mesh& mesh, double x, double width) {
  double sum = 0, count = 0;
  for (const auto& p : mesh.points)
    if (std::abs(p[0] - x) < width) sum += std::hypot(p[1], p[2]), ++count;
  return count > 0 ? sum / count : 0;
}

Distance rod(double half, double radius) {
  return [=](const Vec3d& p) {
    const double r = std::hypot(p[1], p[2]) - radius, x = std::abs(p[0]) - half;
    return std::hypot(std::max(r, 0.0), std::max(x, 0.0)) + std::min(std::max(r, x), 0.0);
  };
}

/// A long bar with one end from the thick and one from the thin object: each end has its object's radius, and
/// the border between them has the prescribed width. The radius changes by the smoothstep across the border.
TEST(Regions, EndsOfALongBar) {
  const double h = 4.0 / 128, thick = 0.5, thin = 0.3;
  const openvdb::BBoxd box({-2.3, -0.8, -0.8}, {2.3, 0.8, 0.8});
  const std::vector<Object> objects{object("thick", rod(2, thick), box, h),
                                    object("thin", rod(2, thin), box, h)};
  for (double border : {0.6, 1.6}) {
    MorphOptions options;
    Region region;
    region.name = "end", region.kind = Region::Kind::kSpine;
    region.from = 0.5, region.to = 1, region.border = border, region.weights = {0, 1};
    options.regions = {region};
    const MorphPlan plan(objects, options);
    const InBetween frame = plan.frame({1, 0});
    const Mesh mesh = surfaceOf(*frame.surface);
    EXPECT_EQ(measureShape(*frame.surface).pieces, 1);
    EXPECT_EQ(frame.foldShare, 0);
    double most = 0;
    for (double x = -1.8; x <= 1.8; x += 0.1) {
      const double s = std::min(std::max(x / border + 0.5, 0.0), 1.0), share = s * s * (3 - 2 * s);
      const double wanted = thick + share * (thin - thick), radius = radiusAt(mesh, x, 0.5 * h);
      most = std::max(most, std::abs(radius - wanted));
      if (std::abs(x) > 0.5 * border + 2 * h) {
        EXPECT_NEAR(radius, wanted, 0.25 * h) << "x " << x;
      }
    }
    std::printf("  border %.1f: radius off by %.2f voxels at most, fold %.4f\n", border, most / h,
                frame.foldShare);
    // A voxel of the border's own slope, and half a lattice node (1/144 of the length).
    EXPECT_LE(most / h, 1.0) << "border " << border;
    // The whole is as long as they are.
    openvdb::BBoxd all;
    for (const auto& p : mesh.points) all.expand(Vec3d(p));
    EXPECT_NEAR(all.extents()[0], 4, h);
  }
}

/// The same by boxes, and by a ball around one end.
TEST(Regions, BoxesAndBalls) {
  const double h = 4.0 / 96;
  const openvdb::BBoxd box({-2.3, -0.8, -0.8}, {2.3, 0.8, 0.8});
  const std::vector<Object> objects{object("round", rod(2, 0.45), box, h),
                                    object("square", shapes::box({2, 0.4, 0.4}, 0.02), box, h)};
  for (const Region::Kind kind : {Region::Kind::kBox, Region::Kind::kSphere}) {
    Region region;
    region.name = "end", region.kind = kind;
    region.box = openvdb::BBoxd(Vec3d(0, -2, -2), Vec3d(3, 2, 2));
    region.center = Vec3d(2, 0, 0), region.radius = 1.2;
    region.border = 0.5, region.weights = {0, 1};
    MorphOptions options;
    options.regions = {region};
    const Mesh mesh = surfaceOf(*MorphPlan(objects, options).frame({1, 0}).surface);
    double off = 0;
    for (const auto& p : mesh.points) {
      const Vec3d q(p);
      const double away = kind == Region::Kind::kBox ? -q[0] : (q - region.center).length() - region.radius;
      if (away > 0.3) off = std::max(off, std::abs(rod(2, 0.45)(q)));
      if (away < -0.3) off = std::max(off, std::abs(shapes::box({2, 0.4, 0.4}, 0.02)(q)));
    }
    std::printf("  off by %.3f voxels\n", off / h);
    EXPECT_LE(off / h, 0.5);
  }
}

TEST(Regions, OneThatHoldsNothingIsRefused) {
  std::vector<Object> objects = fourObjects(32);
  objects.resize(2);
  Region region;
  region.name = "head";
  region.center = Vec3d(9, 0, 0), region.radius = 1, region.weights = {0, 1};
  MorphOptions options;
  options.regions = {region};
  try {
    MorphPlan plan(objects, options);
    FAIL() << "a region far away was taken";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("'head'"), std::string::npos) << e.what();
  }
}

/// Splines through keys overshoot a little: beyond a key the motion that leads to it is extrapolated.
TEST(Many, WeightsBelowNothingLeadOn) {
  std::vector<Object> objects;
  for (double r : {1.0, 2.0})
    objects.push_back(
        object("r", shapes::sphere({0, 0, 0}, r), shapes::cube({0, 0, 0}, r + 0.5), 2 * r / 64));
  const MorphPlan plan(objects);
  const FloatGrid::Ptr frame = plan.frame({-0.2, 1.2}).surface;
  double most = 0;
  for (const auto& p : surfaceOf(*frame).points) most = std::max(most, std::abs(Vec3d(p).length() - 2.2));
  EXPECT_LE(most / frame->voxelSize()[0], 0.25);
  EXPECT_THROW(plan.frame({-0.7, 1.7}), InputError);
}

/// With every kind of path the ends are the objects, and nothing folds or falls apart.
TEST(ContourPaths, FramesHoldTogether) {
  std::vector<Object> objects = fourObjects(64);
  objects.erase(objects.begin());
  for (const ContourPath path : {ContourPath::kLinear, ContourPath::kHermite, ContourPath::kIntrinsic}) {
    MorphOptions options;
    options.path = path;
    options.align = Align::kNone;  // they lie on each other; looking for turns is another test's matter
    const MorphPlan plan({objects[0], objects[2]}, options);
    EXPECT_TRUE(sameValues(*plan.frame({1, 0}).surface, *objects[0].levelSet));
    double volumes = measureShape(*objects[0].levelSet).volume + measureShape(*objects[2].levelSet).volume;
    const InBetween frame = plan.frame({0.5, 0.5});
    const ShapeMeasures m = measureShape(*frame.surface);
    std::printf("  volume %.3f of the mean, fold %.4f\n", 2 * m.volume / volumes, frame.foldShare);
    EXPECT_EQ(m.pieces, 1);
    EXPECT_LE(frame.foldShare, 0.001);
  }
}

}  // namespace
}  // namespace slicemorph

// More than two objects, in proportions that may differ from part to part: 64 voxels along the longest side, 96 to 128
// where a closed form asks for a share of a voxel along an edge; with SLICEMORPH_ALL_TESTS 128 everywhere.
#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/all_tests.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

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

/// Three that are not alike: a long box, a box with a bump, a dumb-bell leaning.
std::vector<Object> threeObjects(int voxels) {
  const double h = 2.4 / voxels;
  const openvdb::BBoxd box = shapes::cube({0, 0, 0}, 1.6);
  const Mat3d lean(0.8, -0.6, 0., 0.6, 0.8, 0., 0., 0., 1.);
  return {object("box", shapes::box({1.2, 0.5, 0.6}, 0.15), box, h),
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

/// Made once for the tests that ask it.
std::shared_ptr<const MorphPlan> planOfThree() {
  static const auto plan = std::make_shared<MorphPlan>(threeObjects(resolution()));
  return plan;
}

SurfaceDistance distance(const FloatGrid& a, const FloatGrid& b) {
  return surfaceDistance(surfaceOf(a), surfaceOf(b));
}

/// However the objects are named and on however many threads the plan is made, the blend is the same to the last
/// bit: nothing depends on either. What differs shows which by SLICEMORPH_ALL_TESTS=1, which changes one thing
/// at a time.
TEST(Many, NeitherOrderNorThreadsMatter) {
  const std::vector<Object> objects = threeObjects(resolution());
  const Weights weights{0.5, 0.3, 0.2};
  const InBetween frame = planOfThree()->frame(weights);
  const ShapeMeasures m = measureShape(*frame.surface);
  for (const Note& note : planOfThree()->notes()) std::printf("  %s\n", note.sentence().c_str());
  std::printf("  %d pieces, genus %d, fold %.4f\n", m.pieces, m.genus, frame.foldShare);
  EXPECT_EQ(m.pieces, 1);
  EXPECT_EQ(m.genus, 0);
  struct Change {
    std::array<size_t, 3> order;
    size_t threads;
  };
  std::vector<Change> changes{{{2, 0, 1}, 3}};
  if (allTests()) changes = {{{2, 0, 1}, 2}, {{1, 2, 0}, 2}, {{0, 1, 2}, 1}, {{0, 1, 2}, 3}};
  for (const Change& change : changes) {
    std::vector<Object> permuted;
    Weights own;
    for (size_t k : change.order) permuted.push_back(objects[k]), own.push_back(weights[k]);
    const FloatGrid::Ptr again =
        withThreads(change.threads, [&] { return MorphPlan(permuted).frame(own).surface; });
    EXPECT_TRUE(sameValues(*again, *frame.surface))
        << change.threads << " threads, first object " << change.order[0];
  }
}

/// Exactly, and what is next to them is next to them.
TEST(Many, UnitWeightsGiveTheObjects) {
  const std::vector<Object> objects = threeObjects(resolution());
  const MorphPlan& plan = *planOfThree();
  for (size_t k = 0; k < objects.size(); ++k) {
    Weights w(objects.size(), 0);
    w[k] = 1;
    // By construction the object's own grid: no resampling at its own voxel size.
    EXPECT_TRUE(sameValues(*plan.frame(w).surface, *objects[k].levelSet)) << objects[k].name;
    // And what is next to it is next to it: a thousandth of the way moves nothing by more than a tenth of a
    // voxel.
    for (double& x : w) x = 0.999 * x + 0.001 / double(objects.size());
    const SurfaceDistance d = distance(*plan.frame(w).surface, *objects[k].levelSet);
    const double h = objects[k].levelSet->voxelSize()[0];
    std::printf("  %s: %.3f mean, %.3f max voxels\n", objects[k].name.c_str(), d.mean / h, d.max / h);
    EXPECT_LE(d.mean / h, 0.1);
    EXPECT_LE(d.max / h, 1.0);
  }
}

/// Spheres of radii r around (r, 0, -r): every blend is one of them.
TEST(Many, BlendsOfThreeSpheres) {
  const Weights radii{1, 2, 3};
  std::vector<Object> objects;
  for (double r : radii)
    objects.push_back(
        object("r", shapes::sphere({r, 0, -r}, r), shapes::cube({r, 0, -r}, r + 0.5), 2 * r / resolution()));
  const MorphPlan plan(objects);
  for (const Weights& weights : {Weights{1 / 3.0, 1 / 3.0, 1 / 3.0}, Weights{0.5, 0.3, 0.2}}) {
    const FloatGrid::Ptr frame = plan.frame(weights).surface;
    const double h = frame->voxelSize()[0];
    double r = 0, most = 0;
    for (size_t k = 0; k < radii.size(); ++k) r += weights[k] * radii[k];
    for (const auto& p : surfaceOf(*frame).points)
      most = std::max(most, std::abs((Vec3d(p) - Vec3d(r, 0, -r)).length() - r));
    std::printf("  radius %.2f off by %.3f voxels at most\n", r, most / h);
    EXPECT_LE(most / h, 0.25);
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

/// A long bar that is thick at one end and thin at the other: each end as it was given, and between them a
/// border whose width is the one asked for. The radius goes over as the smoothstep of the border.
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
  std::vector<Object> objects = threeObjects(32);
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

/// Splines through keys lead a little beyond: what is beyond a key is what leads to it, further on.
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

/// Whatever the way, the ends are the objects, and nothing folds or falls apart.
TEST(ContourPaths, FramesHoldTogether) {
  const std::vector<Object> objects = threeObjects(64);
  for (const ContourPath path : {ContourPath::kHermite, ContourPath::kIntrinsic}) {
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

// Bodies bent onto each other: capsule figures whose limbs swing by known angles.
#include "engine/match/elastic_fit.h"

#include "engine/match/bend_bodies.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/fields.h"
#include "tests/support/quadruped.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace slicemorph {
namespace {

using shapes::capsule;
using shapes::Distance;
using shapes::joined;

const openvdb::BBoxd kElasticBox(Vec3d(-1.4), Vec3d(1.4));
constexpr double kElasticVoxel = 0.03;

Vec3d direction(double degrees) {
  const double a = degrees * M_PI / 180;
  return {std::sin(a), -std::cos(a), 0};
}

/// A trunk along y with an arm of length 1 on its right whose shoulder is at (0.25, 0.4, 0); `swing`: degrees from
/// hanging, in the plane of trunk and arm.
const Vec3d kShoulder(0.25, 0.4, 0);
Distance standingFigure(double swing) {
  return joined(
      {capsule({0, -0.9, 0}, {0, 0.5, 0}, 0.22), capsule(kShoulder, kShoulder + direction(swing), 0.09)});
}

OrientedPoints surfaceOn(const DistanceField& field, const Chart& chart) {
  return chartSamples(field, chart).points;
}

struct Bent {
  BodyGraph graph;
  ElasticFit fit;
};

bool onArm(const Vec3d& p, double swing) {
  const Vec3d own = p - kShoulder;
  return own.dot(direction(swing)) > 0.3 && own.cross(direction(swing)).length() < 0.12;
}

/// The fit of a figure with one swing to one with another. `startSwing`: by which the arm is turned to begin with.
Bent bentFigure(double from, double to, double startSwing = 0) {
  const Chart chart = shapes::straightChart();
  const auto a = shapes::fieldOf(standingFigure(from), kElasticBox, kElasticVoxel),
             b = shapes::fieldOf(standingFigure(to), kElasticBox, kElasticVoxel);
  Bent bent{bodyGraph(*a, chart), {}};
  std::vector<Vec3d> start = bent.graph.position;
  const Mat3d turn = rotationFromVector({0, 0, startSwing * M_PI / 180});
  for (Vec3d& p : start)
    if (onArm(p, from)) p = kShoulder + turn * (p - kShoulder);
  bent.fit = fitElastically(bent.graph, surfaceOn(*a, chart), surfaceOn(*b, chart), {start, {}}, 1);
  return bent;
}

TEST(BodyGraph, DoesNotJoinAcrossGaps) {
  // Two rods a spacing and a half of the graph apart, joined at one end.
  const Distance fork =
      joined({capsule({-1, 0.2, 0}, {1, 0.2, 0}, 0.1), capsule({-1, -0.2, 0}, {1, -0.2, 0}, 0.1),
              capsule({-1, -0.2, 0}, {-1, 0.2, 0}, 0.1)});
  const BodyGraph graph =
      bodyGraph(*shapes::fieldOf(fork, kElasticBox, kElasticVoxel), shapes::straightChart());
  ASSERT_GT(graph.position.size(), 50u);
  for (const BodyGraph::Edge& e : graph.edges) {
    const Vec3d &a = graph.position[size_t(e.from)], &b = graph.position[size_t(e.to)];
    if (a[0] > -0.8 && b[0] > -0.8) {
      EXPECT_GT(a[1] * b[1], 0) << a << b;
    }
  }
}

TEST(BodyGraph, BindingsGivePointsBack) {
  const BodyGraph graph =
      bodyGraph(*shapes::fieldOf(standingFigure(0), kElasticBox, kElasticVoxel), shapes::straightChart());
  const std::vector<Vec3d> points{{0.2, 0, 0}, {0.3, -0.5, 0.02}, {0, 0.7, 0}};
  const std::vector<Vec3d> back = carried(graph, bindPoints(graph, points), graph.position,
                                          std::vector<Mat3d>(graph.position.size(), Mat3d::identity()));
  // Weights in single precision sum to 1 within its rounding.
  for (size_t i = 0; i < points.size(); ++i) EXPECT_LE((back[i] - points[i]).length(), 1e-6);
}

/// A body on itself stays where it is.
TEST(ElasticFit, NothingMovesWhereNothingDiffers) {
  const Bent bent = bentFigure(40, 40);
  EXPECT_LE(bent.fit.strain, 0.02);
  double most = 0;
  for (size_t i = 0; i < bent.graph.position.size(); ++i)
    most = std::max(most, (bent.fit.position[i] - bent.graph.position[i]).length());
  EXPECT_LE(most, 0.5 * kElasticVoxel);
}

/// The arm's nodes go round the shoulder, by 30 degrees from where it is and by 110 from a start that is 25 off: every
/// part of the arm is where the same share of the arm is, within .15 of its length: bending the shoulder, whose radius
/// is .09, shifts it.
TEST(ElasticFit, AnArmGoesRound) {
  const double kFrom = 40;
  for (const auto& [swing, start] : {std::pair<double, double>{30, 0}, {110, 85}}) {
    const Bent bent = bentFigure(kFrom, kFrom + swing, start);
    EXPECT_LE(bent.fit.missed, 0.03) << swing;
    double most = 0;
    for (size_t i = 0; i < bent.graph.position.size(); ++i) {
      if (!onArm(bent.graph.position[i], kFrom)) continue;
      const double along = (bent.graph.position[i] - kShoulder).dot(direction(kFrom));
      most = std::max(most, (bent.fit.position[i] - kShoulder - along * direction(kFrom + swing)).length());
    }
    std::printf("  by %.0f degrees: off by %.3f, strain %.3f\n", swing, most, bent.fit.strain);
    EXPECT_LE(most, 0.15) << swing;
  }
}

/// Half way the arm has turned by half, and is as long as it was; from either side.
TEST(ElasticFit, HalfWayTheArmHasTurnedByHalf) {
  const double kFrom = 40, swing = 100;
  const Bent bent = bentFigure(kFrom, kFrom + swing, 80);
  const ElasticFit half = partWay(bent.graph, bent.fit, 0.5);
  // Means of the nodes near the elbow and near the hand: in the figure, in the fit and half way.
  struct Ends {
    Vec3d near{0, 0, 0}, far{0, 0, 0};
    Vec3d arm() const { return far - near; }
  } own, fitted, middle;
  double nears = 0, fars = 0;
  const auto count = [&](double along, bool far) {
    return far ? along > 0.75 : along > 0.35 && along < 0.55;
  };
  for (bool far : {false, true})
    for (size_t i = 0; i < bent.graph.position.size(); ++i) {
      const Vec3d& p = bent.graph.position[i];
      if (!onArm(p, kFrom) || !count((p - kShoulder).dot(direction(kFrom)), far)) continue;
      (far ? own.far : own.near) += p;
      (far ? fitted.far : fitted.near) += bent.fit.position[i];
      (far ? middle.far : middle.near) += half.position[i];
      ++(far ? fars : nears);
    }
  ASSERT_GT(nears, 3);
  ASSERT_GT(fars, 3);
  for (Ends* ends : {&own, &fitted, &middle}) ends->near /= nears, ends->far /= fars;
  const Vec3d arm = middle.arm();
  // The nodes lie up to a spacing (.08) off the arm's axis, on an arm of which half is looked at: three degrees.
  EXPECT_NEAR(std::atan2(arm[0], -arm[1]) * 180 / M_PI, kFrom + swing / 2, 3);
  // What bends by 50 degrees within a node's reach is shorter by a hundredth.
  EXPECT_NEAR(arm.length() / (0.5 * (own.arm().length() + fitted.arm().length())), 1, 0.01);
}

/// The longest path from a body's deepest node, in depths of that node, between bounds: `least` and `most` are those of
/// the shape itself. Outer nodes lie up to a spacing beyond the surface or before it; paths over neighbours are up to a
/// tenth longer than straight ones.
void expectReach(const Distance& distance, double least, double most) {
  const BodyGraph graph =
      bodyGraph(*shapes::fieldOf(distance, kElasticBox, kElasticVoxel), shapes::straightChart());
  const std::vector<double> paths = graph.distancesFrom(graph.deepest);
  const double reach = *std::max_element(paths.begin(), paths.end()), off = graph.spacing;
  EXPECT_GE(reach / graph.depth, least - off / graph.depth);
  EXPECT_LE(reach / graph.depth, 1.1 * (most + off / graph.depth));
}

TEST(BodyGraph, PathsFromTheDeepestPoint) {
  expectReach(shapes::sphere(Vec3d(0.0), 1), 1, 1);
  expectReach(shapes::box(Vec3d(0.9), 0), std::sqrt(3.0), std::sqrt(3.0));
  // A rod is as deep all along: from anywhere on its axis, so at least half its length and at most the whole.
  expectReach(capsule({-0.8, 0, 0}, {0.8, 0, 0}, 0.25), 1.05 / 0.25, 2.1 / 0.25);
}

bool isBent(const MorphPlan& plan) {
  const Notes& notes = plan.notes();
  return std::any_of(notes.begin(), notes.end(), [](const Note& note) {
    return note.code == "match.bent" || note.code == "match.coupled";
  });
}

/// A box and a rounded one in another direction have nothing that swings: they are matched as they are.
TEST(BendBodies, CompactBodiesAreNot) {
  const auto object = [](const Distance& shape) {
    return Object{"compact", shapes::levelSet(shape, kElasticBox, 2 * kElasticVoxel)};
  };
  const Distance box = shapes::box(Vec3d(0.7), 0), lens = [](const Vec3d&p) {
    return std::max((p - Vec3d(0.6, 0, 0)).length(), (p + Vec3d(0.6, 0, 0)).length()) - 1.2;
  };
  EXPECT_FALSE(isBent(MorphPlan({object(box), object(lens)})));
}

/// The whole way: an animal that runs is met with its legs where they belong, in whatever order the two are named.
TEST(BendBodies, LegsSwingWhole) {
  using shapes::Quadruped;
  const Quadruped::Swing still{0, 0, 0, 0}, running{60, -50, 50, -60};
  const auto object = [](const Quadruped::Swing& swing) {
    return Object{"quadruped", shapes::levelSet(shapes::quadruped(swing), shapes::quadrupedBox(), 1.9 / 96)};
  };
  const Object a = object(still), b = object(running);
  for (bool swapped : {false, true}) {
    const MorphPlan plan = swapped ? MorphPlan({b, a}) : MorphPlan({a, b});
    EXPECT_TRUE(isBent(plan));
    for (int leg = 0; leg < 4; ++leg)
      for (double share : {0.5, 0.9}) {
        const Vec3d from = Quadruped::onLeg(leg, swapped ? running[size_t(leg)] : 0, share),
                    to = Quadruped::onLeg(leg, swapped ? 0 : running[size_t(leg)], share);
        // A twentieth of the body's length of 1.9.
        EXPECT_LE((plan.correspond({from}, 0, 1)[0] - to).length(), 0.095) << swapped << leg << share;
      }
  }
}

}  // namespace
}  // namespace slicemorph

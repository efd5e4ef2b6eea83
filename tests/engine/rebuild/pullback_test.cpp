// Values carried with the shapes against closed forms: Gaussian puffs that travel, turn and grow.
#include "engine/spine/chart.h"
#include "engine/volume/level_set.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"
#include "slicemorph/label_field.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/bent_shapes.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>

namespace slicemorph {
namespace {

using openvdb::GridBase;
constexpr double kPi = 3.14159265358979323846;

/// exp(-|Q^T (p - middle) / widths|^2 / 2), cut where it is below a thousandth, on voxels of edge h.
FloatGrid::Ptr puff(const Vec3d& middle, const Vec3d& widths, double h,
                    const Mat3d& turn = Mat3d::identity()) {
  auto grid = FloatGrid::create(0.f);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setName("density");
  const double reach = 4 * std::max({widths[0], widths[1], widths[2]});
  const openvdb::CoordBBox box(openvdb::Coord::floor((middle - Vec3d(reach)) / h),
                               openvdb::Coord::ceil((middle + Vec3d(reach)) / h));
  auto accessor = grid->getAccessor();
  for (auto it = box.begin(); it; ++it) {
    const Vec3d d = turn.transpose() * (h * (*it).asVec3d() - middle) / widths;
    const double value = std::exp(-0.5 * d.lengthSqr());
    if (value > 1e-3) accessor.setValue(*it, float(value));
  }
  return grid;
}

Object shapeOf(const FloatGrid::Ptr& fog) { return {"puff", toLevelSet(fog, 0, 0.5).grid}; }

struct Figures {
  double total = 0, peak = 0;
  Vec3d middle{0, 0, 0};
  double spread = 0;  ///< root mean square distance from the middle
};

Figures figuresOf(const FloatGrid& grid) {
  Figures f;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    f.total += *it, f.peak = std::max(f.peak, double(*it));
    f.middle += *it * grid.indexToWorld(it.getCoord());
  }
  f.middle /= f.total;
  for (auto it = grid.cbeginValueOn(); it; ++it)
    f.spread += *it * (grid.indexToWorld(it.getCoord()) - f.middle).lengthSqr() / f.total;
  f.spread = std::sqrt(f.spread);
  f.total *= grid.transform().voxelVolume();
  return f;
}

FloatGrid::ConstPtr carried(const MorphPlan& plan, const FloatGrid::Ptr& a, const FloatGrid::Ptr& b, double t,
                            bool conserve = false) {
  return openvdb::gridConstPtrCast<FloatGrid>(plan.pullback({1 - t, t}).carry({a, b}, {conserve}));
}

constexpr double kWidth = 1, kVoxel = 0.2;

TEST(Carry, APuffTravelsWhole) {
  const Vec3d to(8, -5, 3.3);  // ten widths away
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel), b = puff(to, Vec3d(kWidth), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const Figures start = figuresOf(*a);
  for (double t : {0.1, 0.25, 0.5, 0.8}) {
    const Figures f = figuresOf(*carried(plan, a, b, t));
    std::printf("  t %.2f: total %.4f, peak %.4f, spread %.4f, off by %.4f\n", t, f.total / start.total,
                f.peak / start.peak, f.spread / start.spread, (f.middle - t * to).length());
    EXPECT_NEAR(f.total / start.total, 1, 0.02) << t;
    EXPECT_NEAR(f.peak / start.peak, 1, 0.02) << t;
    EXPECT_NEAR(f.spread / start.spread, 1, 0.02) << t;
    EXPECT_LE((f.middle - t * to).length(), 0.1 * kVoxel) << t;
  }
}

/// Half way it has turned by half the angle: its long axis is at 45 degrees.
TEST(Carry, APuffTurns) {
  const Vec3d widths(2, 0.9, 0.6);
  const Mat3d turn = rotationFromVector({0, 0, kPi / 2});
  const FloatGrid::Ptr a = puff({0, 0, 0}, widths, kVoxel), b = puff({0, 0, 0}, widths, kVoxel, turn);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const FloatGrid::Ptr truth = puff({0, 0, 0}, widths, kVoxel, rotationFromVector({0, 0, kPi / 4}));
  const FloatGrid::Ptr other = puff({0, 0, 0}, widths, kVoxel, rotationFromVector({0, 0, -kPi / 4}));
  const FloatGrid::ConstPtr frame = carried(plan, a, b, 0.5);
  double off = 0, offOther = 0;
  for (auto it = truth->cbeginValueOn(); it; ++it)
    off = std::max(off, double(std::abs(*it - frame->tree().getValue(it.getCoord()))));
  for (auto it = other->cbeginValueOn(); it; ++it)
    offOther = std::max(offOther, double(std::abs(*it - frame->tree().getValue(it.getCoord()))));
  const Figures f = figuresOf(*frame), start = figuresOf(*a);
  std::printf("  turned: off by %.4f at most, total %.4f, peak %.4f\n", std::min(off, offOther),
              f.total / start.total, f.peak / start.peak);
  // A quarter turn may go either way round: these puffs look the same after half a turn. Off by a tenth of a
  // voxel at the steepest position is 0.1 * 0.2 / 0.6 * 0.61 = 0.02; the interpolation of a peak of width 3
  // voxels adds 1/8 / 3^2.
  EXPECT_LE(std::min(off, offOther), 0.035);
  EXPECT_NEAR(f.total / start.total, 1, 0.02);
}

/// Twice the size: without `conserve` the values are kept and the total follows the volume; with it the total
/// is linear in time.
TEST(Carry, APuffGrows) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel),
                       b = puff({0, 0, 0}, Vec3d(2 * kWidth), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const Figures start = figuresOf(*a), end = figuresOf(*b);
  for (double t : {0.25, 0.5, 0.75}) {
    const double size = 1 + t;
    const Figures free = figuresOf(*carried(plan, a, b, t)), kept = figuresOf(*carried(plan, a, b, t, true));
    std::printf("  t %.2f: total %.4f of cubic, %.4f of linear\n", t,
                free.total / (start.total * size * size * size),
                kept.total / ((1 - t) * start.total + t * end.total));
    EXPECT_NEAR(free.total / (start.total * size * size * size), 1, 0.02) << t;
    EXPECT_NEAR(free.peak, 1, 0.02) << t;
    EXPECT_NEAR(kept.total / ((1 - t) * start.total + t * end.total), 1, 0.02) << t;
  }
}

/// Vectors turn with their shape.
TEST(Carry, VectorsTurn) {
  const Vec3d widths(2, 0.9, 0.6);
  const FloatGrid::Ptr a = puff({0, 0, 0}, widths, kVoxel);
  const FloatGrid::Ptr b = puff({0, 0, 0}, widths, kVoxel, rotationFromVector({0, 0, kPi / 3}));
  const auto vectors = [](const FloatGrid& like, const Vec3d& v) {
    auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.f));
    grid->setTransform(like.transform().copy());
    for (auto it = like.cbeginValueOn(); it; ++it) grid->tree().setValue(it.getCoord(), openvdb::Vec3s(v));
    return grid;
  };
  const Vec3d along(1, 0, 0);
  const GridBase::ConstPtr va = vectors(*a, along),
                           vb = vectors(*b, rotationFromVector({0, 0, kPi / 3}) * along);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const auto frame = openvdb::gridConstPtrCast<openvdb::Vec3SGrid>(plan.pullback({0.5, 0.5}).carry({va, vb}));
  const Vec3d v(frame->tree().getValue({0, 0, 0})), wanted = rotationFromVector({0, 0, kPi / 6}) * along;
  EXPECT_LE((v - wanted).length(), 0.02) << v;
}

/// What flows out of a block of voxels is what its total loses: d rho / dt + div(rho v) is only the
/// exchange of one fog for the other, which is no motion. Printed for the pair as it is and with that
/// exchange left out.
void expectContinuity(const std::vector<GridBase::ConstPtr>& grids, const char* name, double limit) {
  const auto fog = [&](size_t k) { return openvdb::gridConstPtrCast<FloatGrid>(grids[k]); };
  const MorphPlan plan({{"a", toLevelSet(fog(0)).grid}, {"b", toLevelSet(fog(1)).grid}});
  constexpr double kStep = 0.01;
  constexpr int kBlock = 8;
  const auto at = [&](double t, const std::vector<GridBase::ConstPtr>& g) {
    return openvdb::gridConstPtrCast<FloatGrid>(plan.pullback({1 - t, t}).carry(g, {true}));
  };
  const FloatGrid::ConstPtr before = at(0.5 - kStep, grids), after = at(0.5 + kStep, grids),
                            now = at(0.5, grids);
  const FloatGrid::ConstPtr a = at(0.5, {grids[0], nullptr}),
                            b = at(0.5, {nullptr, grids[1]});  // each times 0.5
  const openvdb::Vec3SGrid::Ptr v = plan.pullback({0.5, 0.5}).velocity(*now, {-1, 1}, {0.05});
  const auto flow = [&](const openvdb::Coord& c, int axis) {
    return double(now->tree().getValue(c)) * v->tree().getValue(c)[axis];
  };
  std::map<openvdb::Coord, std::array<double, 3>> blocks;  // change, divergence, exchange
  for (auto it = v->cbeginValueOn(); it; ++it) {
    const openvdb::Coord c = it.getCoord();
    auto& sum = blocks[openvdb::Coord::floor(c.asVec3d() / kBlock)];
    sum[0] += (after->tree().getValue(c) - before->tree().getValue(c)) / (2 * kStep);
    for (int axis = 0; axis < 3; ++axis) {
      openvdb::Coord low = c, high = c;
      --low[axis], ++high[axis];
      sum[1] += (flow(high, axis) - flow(low, axis)) / (2 * v->voxelSize()[axis]);
    }
    sum[2] += 2 * (b->tree().getValue(c) - a->tree().getValue(c));
  }
  double change = 0, residual = 0, withExchange = 0;
  for (const auto& [block, sum] : blocks) {
    change += std::abs(sum[0]), residual += std::abs(sum[0] + sum[1] - sum[2]),
        withExchange += std::abs(sum[0] + sum[1]);
  }
  std::printf("  %s: continuity residual %.4f of the change, %.4f with the exchange of the two\n", name,
              residual / change, withExchange / change);
  EXPECT_LE(residual / change, limit) << name;
}

TEST(Carry, MassFlowsAsTheVelocitiesSay) {
  // Blocks of 8 voxels, puffs of 5 voxels width: central differences over a voxel miss (2 pi / (4 * 5))^2 / 6
  // = .016 of a wave that is four widths long, and the map's own derivatives as much again.
  expectContinuity({puff({0, 0, 0}, {1, 1.2, 0.9}, kVoxel), puff({3, 2, 0}, {1.5, 1, 0.9}, kVoxel)}, "puffs",
                   0.04);
  const std::string first = SLICEMORPH_SHARED "/vdb/c42_gas_0006.vdb",
                    second = SLICEMORPH_SHARED "/vdb/c42_gas_0010.vdb";
  if (!std::ifstream(first)) {
    std::printf("  skipped: there is no %s\n", first.c_str());
    return;
  }
  std::vector<GridBase::ConstPtr> grids;
  for (const std::string& path : {first, second}) {
    const LoadedObject loaded = loadObject(path + ":density");
    grids.push_back(loaded.file->read(loaded.grid));
  }
  // Detail of two voxels across, which differences over two voxels do not resolve.
  expectContinuity(grids, "smoke", 0.25);
}

/// Voxels of velocities that are as large as a tolerance of a tenth of a voxel per frame (of `step` units of time) allows:
/// they move points as fine ones do to within that, with fewer voxels, none of which is 0, and are active wherever a
/// point is within half a frame.
void expectCoarseVelocities(const Pullback& pullback, const FloatGrid& here, const Mesh& points,
                            const openvdb::Vec3SGrid& fine, double step) {
  const double h = here.voxelSize()[0], most = 0.1 * h / step;
  const openvdb::Vec3SGrid::Ptr coarse = pullback.velocity(here, {-1, 1}, {step / 2, most});
  EXPECT_GE(coarse->voxelSize()[0], 2 * h);
  EXPECT_LE(4 * coarse->activeVoxelCount(), fine.activeVoxelCount());
  for (auto value = coarse->cbeginValueOn(); value; ++value) ASSERT_NE(*value, openvdb::Vec3s(0.f));
  double worst = 0;
  size_t uncovered = 0;
  for (const openvdb::Vec3s& p : points.points) {
    const Vec3d at(p);
    const Vec3d fineValue(openvdb::tools::BoxSampler::sample(fine.tree(), fine.worldToIndex(at)));
    const Vec3d value(openvdb::tools::BoxSampler::sample(coarse->tree(), coarse->worldToIndex(at)));
    worst = std::max(worst, (value - fineValue).length());
    for (int s = -4; s <= 4; ++s) {
      const openvdb::Coord cell =
          openvdb::Coord::floor(coarse->worldToIndex(at + s / 4.0 * step / 2 * fineValue));
      for (int corner = 0; corner < 8; ++corner)
        uncovered += !coarse->tree().isValueOn(cell.offsetBy(corner & 1, corner >> 1 & 1, corner >> 2));
    }
  }
  std::printf("  coarse velocities: voxels %.0f times as large, wrong by up to %.3f voxels per frame\n",
              coarse->voxelSize()[0] / h, worst * step / h);
  EXPECT_LE(worst, most);
  EXPECT_EQ(uncovered, 0u);
}

/// Points of a frame moved by their velocities arrive on the next frame.
TEST(Carry, FramesFollowTheirVelocities) {
  constexpr int kFrames = 24;
  constexpr double h = 2.0 / 128;
  const shapes::Distance bar = shapes::box({1, 0.14, 0.1}, 0.04);
  Mesh straight = surfaceOf(*shapes::levelSet(bar, openvdb::BBoxd(Vec3d(-1.1), Vec3d(1.1)), h / 2));
  const shapes::Curl curl(Vec3d(0, 0, 120 * kPi / 180 / 2));
  const MorphPlan plan({{"bar", voxelise(straight, h)}, {"bent", voxelise(shapes::bent(straight, curl), h)}});
  for (int i : {1, 8, 16, 22}) {
    const double t = double(i - 1) / (kFrames - 1), step = 1.0 / (kFrames - 1);
    const Mesh points = surfaceOf(*plan.frame({1 - t, t}).surface);
    const FloatGrid::Ptr next = plan.frame({1 - t - step, t + step}).surface;
    const FloatGrid::Ptr here = plan.frame({1 - t, t}).surface;
    const Pullback pullback = plan.pullback({1 - t, t});
    const openvdb::Vec3SGrid::Ptr v = pullback.velocity(*here, {-1, 1});
    expectCoarseVelocities(pullback, *here, points, *v, step);
    double worst = 0, farthest = 0;
    for (const openvdb::Vec3s& p : points.points) {
      const Vec3d at = here->worldToIndex(Vec3d(p));
      const Vec3d displacement = step * Vec3d(openvdb::tools::BoxSampler::sample(v->tree(), at));
      farthest = std::max(farthest, displacement.length() / h);
      worst = std::max(worst, std::abs(double(openvdb::tools::BoxSampler::sample(
                                  next->tree(), next->worldToIndex(Vec3d(p) + displacement)))) /
                                  h);
    }
    std::printf("  frame %d: moved by up to %.2f voxels, lands within %.3f of the next\n", i, farthest,
                worst);
    EXPECT_LE(worst, 0.5) << i;
    EXPECT_GE(farthest, 1) << i;
  }
}

/// Staggered vectors turn with their shape; each component is sampled on its own face.
TEST(Carry, StaggeredFacesStay) {
  const Vec3d widths(2, 0.9, 0.6);
  const auto field = [](const Mat3d& turn, const Vec3d& p) {
    return turn * Vec3d(std::sin(2 * (turn.transpose() * p)[0]), 0, 0);
  };
  const auto onFaces = [&](const FloatGrid& like, const Mat3d& turn, const openvdb::Coord& c) {
    openvdb::Vec3s v;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d face = c.asVec3d();
      face[axis] -= 0.5;
      v[axis] = float(field(turn, like.indexToWorld(face))[axis]);
    }
    return v;
  };
  const auto turned = [](double angle) { return rotationFromVector({0, 0, angle}); };
  const FloatGrid::Ptr a = puff({0, 0, 0}, widths, kVoxel),
                       b = puff({0, 0, 0}, widths, kVoxel, turned(kPi / 3));
  const auto vectors = [&](const FloatGrid& like, const Mat3d& turn) {
    auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.f));
    grid->setTransform(like.transform().copy());
    grid->setGridClass(openvdb::GRID_STAGGERED);
    for (auto it = like.cbeginValueOn(); it; ++it)
      grid->tree().setValue(it.getCoord(), onFaces(like, turn, it.getCoord()));
    return grid;
  };
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  Pullback pullback = plan.pullback({0.5, 0.5});
  const auto frame = openvdb::gridConstPtrCast<openvdb::Vec3SGrid>(
      pullback.carry({vectors(*a, turned(0)), vectors(*b, turned(kPi / 3))}));
  const FloatGrid::ConstPtr shape = openvdb::gridConstPtrCast<FloatGrid>(pullback.carry({a, b}));
  double off = 0;
  for (auto it = shape->cbeginValueOn(); it; ++it)
    if (*it > 0.2)
      off = std::max(off, double((frame->tree().getValue(it.getCoord()) -
                                  onFaces(*shape, turned(kPi / 6), it.getCoord()))
                                     .length()));
  std::printf("  staggered: off by %.4f at most\n", off);
  // Values taken half a voxel off would be 2 * .1 = .2 off; splines of sin(2 x) on voxels of .2 lose .003,
  // the map .02.
  EXPECT_LE(off, 0.06);
  EXPECT_EQ(frame->getGridClass(), openvdb::GRID_STAGGERED);
}

/// Labels are not averaged: the heavier object's are taken, each from a single voxel.
TEST(Carry, LabelsAreNotBlended) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel), b = puff({4, 0, 0}, Vec3d(kWidth), kVoxel);
  const auto labels = [](const FloatGrid& like, int label) {
    auto grid = openvdb::Int32Grid::create(0);
    grid->setTransform(like.transform().copy());
    for (auto it = like.cbeginValueOn(); it; ++it) grid->tree().setValue(it.getCoord(), label);
    return grid;
  };
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  for (double t : {0.3, 0.7}) {
    const auto frame = openvdb::gridConstPtrCast<openvdb::Int32Grid>(
        plan.pullback({1 - t, t}).carry({labels(*a, 7), labels(*b, 90)}));
    EXPECT_GT(frame->activeVoxelCount(), a->activeVoxelCount() / 2);
    for (auto it = frame->cbeginValueOn(); it; ++it) ASSERT_EQ(*it, t < 0.5 ? 7 : 90);
  }
}

TEST(Carry, SameForAnyNumberOfThreads) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, {1, 1.4, 0.8}, kVoxel), b = puff({4, 0, 0}, Vec3d(1.3), kVoxel);
  std::vector<FloatGrid::ConstPtr> frames;
  for (int threads : {1, 4})
    withThreads(size_t(threads), [&] {
      const MorphPlan plan({shapeOf(a), shapeOf(b)});
      frames.push_back(carried(plan, a, b, 0.4, true));
    });
  EXPECT_TRUE(sameValues(*frames[0], *frames[1]));
}

TEST(Carry, EndsAreTheInputs) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel),
                       b = puff({4, 0, 0}, Vec3d(kWidth, 1.3, 0.8), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  EXPECT_EQ(plan.pullback({1, 0}).carry({a, b}), a);
  EXPECT_EQ(plan.pullback({0, 1}).carry({a, b}), b);
}

/// The message of the exception that the call throws; empty if it throws none.
std::string refusalOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(Carry, RatesThatAreNoneAreRefused) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel), b = puff({4, 0, 0}, Vec3d(kWidth), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const Pullback pullback = plan.pullback({0.5, 0.5});
  EXPECT_EQ(refusalOf([&] { pullback.velocity(*a, {-1, 1, 0}); }), "3 rates were given for 2 objects");
  EXPECT_EQ(refusalOf([&] { pullback.velocity(*a, {}); }), "0 rates were given for 2 objects");
  EXPECT_NE(refusalOf([&] { pullback.velocity(*a, {-1, std::nan("")}); }), "");
  EXPECT_NE(refusalOf([&] { pullback.velocity(*a, {0.5, 0.5}); }).find("must sum to 0"), std::string::npos);
  EXPECT_NE(refusalOf([&] { pullback.velocity(*a, {-1, 1}, {-0.1}); }), "");
  // Derivatives of spline weights sum to 0 up to rounding.
  EXPECT_EQ(refusalOf([&] { pullback.velocity(*a, {-24.1, 24.1 + 1e-12}); }), "");
}

/// A scan beside itself and another: where only its own weights count it is itself, to the bit.
TEST(Carry, ImagesOfOneShapeStay) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel), b = puff({4, 0, 0}, Vec3d(kWidth), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b), shapeOf(a)});
  Image image, other;
  image.lattice.size = {7, 6, 5};
  image.lattice.origin = {-2.3, -1.1, -0.7};
  std::vector<float> values(image.lattice.count());
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(i % 17) / 3;
  image.values = values;
  other = image, other.values = std::vector<float>(values.size(), 2);
  for (double w : {0.001, 1.0 / 3, 0.5})
    EXPECT_EQ(plan.pullback({w, 0, 1 - w}).carry({&image, &other, &image}, image.lattice, {1, 1, 1}).values,
              image.values)
        << w;
}

TEST(Carry, ImagesAndLabelsThatAreMissingAreRefused) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel), b = puff({4, 0, 0}, Vec3d(kWidth), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  Image image;
  image.lattice.size = {4, 3, 2};
  image.lattice.origin = {-2, -1, -1};
  image.values = std::vector<std::uint8_t>(24, 1);
  Image cut = image;
  cut.values = std::vector<std::uint8_t>(23, 1);
  const LabelField labels(image);
  ImageLattice nowhere = image.lattice;
  nowhere.size[1] = 0;
  for (const Weights& weights : {Weights{0.5, 0.5}, Weights{1, 0}}) {
    const Pullback pullback = plan.pullback(weights);
    using Images = std::vector<const Image*>;
    const auto images = [&](const Images& given, const ImageLattice& on,
                            const std::vector<double>& isos = {}) {
      return refusalOf([&] { pullback.carry(given, on, isos); });
    };
    const ImageLattice& on = image.lattice;
    EXPECT_EQ(images({&image}, on), "1 images were given for 2 objects");
    EXPECT_EQ(images({&image, nullptr}, on), "object 2 of 2 has no image; every object needs one");
    EXPECT_EQ(images({&image, &image}, on, {0.5}), "1 isovalues were given for 2 objects");
    EXPECT_EQ(images({&cut, &image}, on), "the image of object 1 has 23 values for 24 voxels");
    EXPECT_NE(images({&image, &image}, nowhere).find("4 x 0 x 2"), std::string::npos);
    EXPECT_EQ(images({&image, &image}, on), "");
    using Labels = std::vector<const LabelField*>;
    EXPECT_EQ(refusalOf([&] {
                pullback.carryLabels(Labels{nullptr, &labels}, on);
              }),
              "object 1 of 2 has no label map; every object needs one");
    EXPECT_NE(refusalOf([&] { pullback.carryLabels(Labels{&labels, &labels}, nowhere); }), "");
  }
}

}  // namespace
}  // namespace slicemorph

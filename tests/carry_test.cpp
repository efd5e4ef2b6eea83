// Values that ride with the shapes, against closed forms: Gaussian puffs that travel, turn and grow.
#include "engine/slicemorph.h"
#include "engine/spine/chart.h"
#include "engine/volume/level_set.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace slicemorph {
namespace {

using openvdb::GridBase;
constexpr double kPi = 3.14159265358979323846;

/// exp(-|Q^T (p - middle) / widths|^2 / 2), cut where it is below a thousandth, on voxels of edge h.
FloatGrid::Ptr puff(const Vec3d& middle, const Vec3d& widths, double h, const Mat3d& turn = Mat3d::identity()) {
  auto grid = FloatGrid::create(0.f);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setName("density");
  const double reach = 4 * std::max({widths[0], widths[1], widths[2]});
  const openvdb::CoordBBox box(openvdb::Coord::floor((middle - Vec3d(reach)) / h), openvdb::Coord::ceil((middle + Vec3d(reach)) / h));
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
  double spread = 0;  ///< root of the mean square distance from the middle
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
  return openvdb::gridConstPtrCast<FloatGrid>(plan.carrier({1 - t, t}).carry({a, b}, {conserve}));
}

constexpr double kWidth = 1, kVoxel = 0.2;

TEST(Carry, APuffTravelsWhole) {
  const Vec3d to(8, -5, 3.3);  // ten widths away
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel), b = puff(to, Vec3d(kWidth), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const Figures start = figuresOf(*a);
  for (double t : {0.1, 0.25, 0.5, 0.8}) {
    const Figures f = figuresOf(*carried(plan, a, b, t));
    std::printf("  t %.2f: total %.4f, peak %.4f, spread %.4f, off by %.4f\n", t, f.total / start.total, f.peak / start.peak,
                f.spread / start.spread, (f.middle - t * to).length());
    EXPECT_NEAR(f.total / start.total, 1, 0.02) << t;
    EXPECT_NEAR(f.peak / start.peak, 1, 0.02) << t;
    EXPECT_NEAR(f.spread / start.spread, 1, 0.02) << t;
    EXPECT_LE((f.middle - t * to).length(), 0.1 * kVoxel) << t;
  }
}

/// Half way it has turned by half: its long axis lies at 45 degrees.
TEST(Carry, APuffTurns) {
  const Vec3d widths(2, 0.9, 0.6);
  const Mat3d turn = rotationFromVector({0, 0, kPi / 2});
  const FloatGrid::Ptr a = puff({0, 0, 0}, widths, kVoxel), b = puff({0, 0, 0}, widths, kVoxel, turn);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const FloatGrid::Ptr truth = puff({0, 0, 0}, widths, kVoxel, rotationFromVector({0, 0, kPi / 4}));
  const FloatGrid::Ptr other = puff({0, 0, 0}, widths, kVoxel, rotationFromVector({0, 0, -kPi / 4}));
  const FloatGrid::ConstPtr frame = carried(plan, a, b, 0.5);
  double off = 0, offOther = 0;
  for (auto it = truth->cbeginValueOn(); it; ++it) off = std::max(off, double(std::abs(*it - frame->tree().getValue(it.getCoord()))));
  for (auto it = other->cbeginValueOn(); it; ++it)
    offOther = std::max(offOther, double(std::abs(*it - frame->tree().getValue(it.getCoord()))));
  const Figures f = figuresOf(*frame), start = figuresOf(*a);
  std::printf("  turned: off by %.4f at most, total %.4f, peak %.4f\n", std::min(off, offOther), f.total / start.total, f.peak / start.peak);
  // A quarter turn may go either way round: these puffs look the same after half a turn. Off by a tenth of a voxel at
  // the steepest place is 0.1 * 0.2 / 0.6 * 0.61 = 0.02; the interpolation of a peak of width 3 voxels adds 1/8 / 3^2.
  EXPECT_LE(std::min(off, offOther), 0.035);
  EXPECT_NEAR(f.total / start.total, 1, 0.02);
}

/// Twice the size: without `conserve` values stay and the total follows the volume, with it the total stays linear.
TEST(Carry, APuffGrows) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel), b = puff({0, 0, 0}, Vec3d(2 * kWidth), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const Figures start = figuresOf(*a), end = figuresOf(*b);
  for (double t : {0.25, 0.5, 0.75}) {
    const double size = 1 + t;
    const Figures free = figuresOf(*carried(plan, a, b, t)), kept = figuresOf(*carried(plan, a, b, t, true));
    std::printf("  t %.2f: total %.4f of cubic, %.4f of linear\n", t, free.total / (start.total * size * size * size),
                kept.total / ((1 - t) * start.total + t * end.total));
    EXPECT_NEAR(free.total / (start.total * size * size * size), 1, 0.02) << t;
    EXPECT_NEAR(free.peak, 1, 0.02) << t;
    EXPECT_NEAR(kept.total / ((1 - t) * start.total + t * end.total), 1, 0.02) << t;
  }
}

/// Vectors turn with the shape that carries them.
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
  const GridBase::ConstPtr va = vectors(*a, along), vb = vectors(*b, rotationFromVector({0, 0, kPi / 3}) * along);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  const auto frame = openvdb::gridConstPtrCast<openvdb::Vec3SGrid>(plan.carrier({0.5, 0.5}).carry({va, vb}));
  const Vec3d v(frame->tree().getValue({0, 0, 0})), wanted = rotationFromVector({0, 0, kPi / 6}) * along;
  EXPECT_LE((v - wanted).length(), 0.02) << v;
}

TEST(Carry, EndsAreTheInputs) {
  const FloatGrid::Ptr a = puff({0, 0, 0}, Vec3d(kWidth), kVoxel), b = puff({4, 0, 0}, Vec3d(kWidth, 1.3, 0.8), kVoxel);
  const MorphPlan plan({shapeOf(a), shapeOf(b)});
  EXPECT_EQ(plan.carrier({1, 0}).carry({a, b}), a);
  EXPECT_EQ(plan.carrier({0, 1}).carry({a, b}), b);
}

}  // namespace
}  // namespace slicemorph

// Label maps carried by known maps.
#include "engine/rebuild/warp_labels.h"
#include "tests/support/shifted_nodes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace slicemorph {
namespace {

ImageLattice latticeOf(int side, double first) {
  ImageLattice lattice{{side, side, side}, Vec3d(first)};
  return lattice;
}

Image labelled(const ImageLattice& lattice, const std::function<int(const Vec3d&)>& label) {
  std::vector<std::int32_t> values;
  for (int k = 0; k < lattice.size[2]; ++k)
    for (int j = 0; j < lattice.size[1]; ++j)
      for (int i = 0; i < lattice.size[0]; ++i) values.push_back(label(lattice.toWorld(Vec3d(i, j, k))));
  return {lattice, values};
}

std::vector<int> numbersOf(const Image& image) {
  return std::visit([](const auto& values) { return std::vector<int>(values.begin(), values.end()); },
                    image.values);
}

/// A ball of label 3 inside one of label 500.
int nested(const Vec3d& p, double size) { return p.length() < 0.5 * size ? 3 : p.length() < size ? 500 : 0; }

/// Shifted by a whole number of voxels: the same labels, elsewhere.
TEST(WarpLabels, ShiftsMoveLabels) {
  const ImageLattice lattice = latticeOf(24, -11.5);
  const LabelField field(labelled(lattice, [](const Vec3d& p) { return nested(p, 8); }));
  CarriedLabels carried;
  carried.labels = &field, carried.weight = 1;
  const Vec3d shift(2, -1, 3);
  const Image result = warpLabels({carried}, shiftedNodes(lattice, {shift}), lattice);
  EXPECT_EQ(result.values.index(), ImageValues(std::vector<std::uint16_t>()).index());
  const std::vector<int> numbers = numbersOf(result);
  for (int k = 0; k < 24; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i)
        ASSERT_EQ(numbers[lattice.index(i, j, k)], nested(lattice.toWorld(Vec3d(i, j, k)) + shift, 8));
}

/// Half way between balls of 6 and 10 voxels: 8, within the half voxel by which distances to voxel centres
/// may be off on either side.
TEST(WarpLabels, DepthsAreBlended) {
  const ImageLattice lattice = latticeOf(28, -13.5);
  const LabelField small(labelled(lattice, [](const Vec3d&p) { return nested(p, 6); })),
      large(labelled(lattice, [](const Vec3d&p) { return nested(p, 10); }));
  std::vector<CarriedLabels> carried(2);
  carried[0].labels = &small, carried[1].labels = &large, carried[1].shape = 1;
  carried[0].weight = carried[1].weight = 0.5;
  const std::vector<int> numbers =
      numbersOf(warpLabels(carried, shiftedNodes(lattice, {Vec3d(0.0), Vec3d(0.0)}), lattice));
  for (int k = 0; k < 28; ++k)
    for (int j = 0; j < 28; ++j)
      for (int i = 0; i < 28; ++i) {
        const Vec3d p = lattice.toWorld(Vec3d(i, j, k));
        const double toRim = std::min(std::abs(p.length() - 8), std::abs(p.length() - 4));
        if (toRim > 0.75) {
          ASSERT_EQ(numbers[lattice.index(i, j, k)], nested(p, 8)) << p;
        }
      }
}

/// Two boxes that share a face: however far it moves there is no gap between them, not even in the outermost
/// voxels, where no label is deep.
TEST(WarpLabels, NeighboursStayNeighbours) {
  const ImageLattice lattice = latticeOf(20, -9.5);
  const auto boxes = [&](double face) {
    return labelled(lattice, [=](const Vec3d& p) {
      if (std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}) > 7) return 0;
      return p[0] < face ? 1 : 2;
    });
  };
  const LabelField a(boxes(-4)), b(boxes(4));
  std::vector<CarriedLabels> carried(2);
  carried[0].labels = &a, carried[1].labels = &b, carried[1].shape = 1;
  for (double t : {0.25, 0.5, 0.75}) {
    carried[0].weight = 1 - t, carried[1].weight = t;
    const Image result = warpLabels(carried, shiftedNodes(lattice, {Vec3d(0.0), Vec3d(0.0)}), lattice);
    EXPECT_EQ(result.values.index(), ImageValues(std::vector<std::uint8_t>()).index());
    const std::vector<int> numbers = numbersOf(result);
    for (int k = 0; k < 20; ++k)
      for (int j = 0; j < 20; ++j)
        for (int i = 0; i < 20; ++i) {
          const Vec3d p = lattice.toWorld(Vec3d(i, j, k));
          const bool inside = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}) < 7;
          const int found = numbers[lattice.index(i, j, k)];
          ASSERT_EQ(found != 0, inside) << p;
          if (inside && std::abs(p[0] + 4 - 8 * t) > 1) {
            ASSERT_EQ(found, p[0] < 8 * t - 4 ? 1 : 2) << p << " " << t;
          }
        }
  }
}

/// A label that one object lacks shrinks to nothing as that object's weight grows.
TEST(WarpLabels, WhatIsAbsentShrinks) {
  const ImageLattice lattice = latticeOf(24, -11.5);
  const LabelField with(labelled(lattice, [](const Vec3d&p) { return nested(p, 9); })),
      without(labelled(lattice, [](const Vec3d&p) { return p.length() < 9 ? 500 : 0; }));
  std::vector<CarriedLabels> carried(2);
  carried[0].labels = &with, carried[1].labels = &without, carried[1].shape = 1;
  std::ptrdiff_t before = 1 << 20;
  for (double t : {0.0, 0.2, 0.4, 0.9, 1.0}) {
    carried[0].weight = 1 - t, carried[1].weight = t;
    const std::vector<int> numbers =
        numbersOf(warpLabels(carried, shiftedNodes(lattice, {Vec3d(0.0), Vec3d(0.0)}), lattice));
    const std::ptrdiff_t count = std::count(numbers.begin(), numbers.end(), 3);
    EXPECT_LT(count, before + (t == 1)) << t;
    if (t == 0) {
      EXPECT_GT(count, 300);
    }
    if (t == 1) {
      EXPECT_EQ(count, 0);
    }
    before = count;
  }
}

}  // namespace
}  // namespace slicemorph

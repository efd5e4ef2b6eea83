#include "engine/reconstruct/fill_gaps.h"
#include "slicemorph/errors.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <mutex>
#include <new>

namespace slicemorph {
namespace {

constexpr int kStep = 3, kSlices = 64, kSide = 40;

/// Two tubes that wind round each other and a ball, on every third slice along an axis.
Image windingTubes(int axis) {
  Image image;
  image.lattice.size = openvdb::Coord(kSide);
  image.lattice.size[axis] = kSlices;
  image.lattice.step[1] = {0, 0.5, 0};
  std::vector<std::int16_t> values(image.lattice.count(), 0);
  const openvdb::Coord n = image.lattice.size;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const openvdb::Coord c(i, j, k);
        const double s = c[axis], x = c[axis == 0 ? 1 : 0], y = c[axis == 2 ? 1 : 2];
        if (c[axis] % kStep != 0) continue;
        std::int16_t& label = values[image.lattice.index(i, j, k)];
        const double u = 9 * std::cos(0.1 * s), v = 9 * std::sin(0.1 * s);
        if (std::hypot(x - 20 - u, y - 20 - v) < 5) label = 7;
        if (std::hypot(x - 20 + u, y - 20 + v) < 6) label = 300;
        if (Vec3d(x - 30, y - 8, s - 31).length() < 8) label = 2;
      }
  image.values = std::move(values);
  return image;
}

GivenSlices everyThird(int axis) {
  GivenSlices given{axis, {}};
  for (int at = 0; at < kSlices; at += kStep) given.at.push_back(at);
  return given;
}

/// All planes at once, gap after gap.
Image filledAtOnce(Image image, const GivenSlices& given) {
  RankedSlices ranked = rankSlices(image, given);
  const SliceScores scores(std::move(ranked.stack));
  const double spacing = image.lattice.spacing()[given.axis];
  const SliceLayout layout = layoutOf(image.lattice, given.axis);
  auto& values = std::get<std::vector<std::int16_t>>(image.values);
  for (size_t g = 0; g + 1 < given.at.size(); ++g) {
    std::vector<double> positions;
    for (int s = given.at[g] + 1; s < given.at[g + 1]; ++s) positions.push_back(s * spacing);
    const std::vector<int> won = scores.labelsBetween(positions);
    for (size_t i = 0; i < won.size(); ++i) {
      const size_t x = i % size_t(layout.width), y = i / size_t(layout.width) % size_t(layout.height);
      const size_t s = i / size_t(layout.width) / size_t(layout.height) + size_t(given.at[g] + 1);
      values[s * layout.slice + y * layout.y + x * layout.x] = std::int16_t(ranked.values[size_t(won[i])]);
    }
  }
  return image;
}

/// There are 21 gaps, more than are filled at once; what is found of one must not depend on where a filling begins.
TEST(FillGaps, AFewAtATimeIsAllAtOnce) {
  for (int axis : {0, 1, 2}) {
    const Image sparse = windingTubes(axis);
    const GivenSlices given = everyThird(axis);
    const Image expected = filledAtOnce(sparse, given);
    ASSERT_NE(expected.values, sparse.values);
    for (size_t threads : {1, 2, 5})
      withThreads(threads, [&] {
        EXPECT_EQ(interpolateLabels(sparse, given).values, expected.values) << axis << " " << threads;
      });
  }
}

/// Slices are asked for once each, and only those that were announced.
TEST(FillGaps, AsksForEachSliceOnce) {
  const Image sparse = windingTubes(2);
  const GivenSlices given = everyThird(2);
  const SliceLayout layout = layoutOf(sparse.lattice, 2);
  GapFiller filler(sparse.lattice, given, {2, 7, 300, 0});
  std::vector<int> asked(given.at.size(), 0);
  std::vector<size_t> gaps;
  std::mutex one;
  while (!filler.done()) {
    const size_t announced = filler.slicesNeeded();
    ASSERT_LE(filler.next().end - filler.next().first, announced);
    filler.fill(
        [&](size_t n) {
          EXPECT_LT(n, announced);
          ++asked[n];
          return LabelSlice{sparse.values, layout, given.at[n]};
        },
        [&](const FilledGap& gap) {
          const std::lock_guard<std::mutex> lock(one);
          EXPECT_EQ(gap.slices, kStep - 1);
          gaps.push_back(gap.gap);
        });
  }
  EXPECT_EQ(asked, std::vector<int>(given.at.size(), 1));
  std::sort(gaps.begin(), gaps.end());
  ASSERT_EQ(gaps.size(), given.at.size() - 1);
  for (size_t g = 0; g < gaps.size(); ++g) EXPECT_EQ(gaps[g], g);
}

/// What one gap throws, as where memory is short, is thrown when the others are done: their inner loops go on whole.
TEST(FillGaps, OneThatFailsLeavesTheOthersWhole) {
  const Image sparse = windingTubes(2);
  const GivenSlices given = everyThird(2);
  const SliceLayout layout = layoutOf(sparse.lattice, 2);
  const Image expected = interpolateLabels(sparse, given);
  const std::vector<double> ranked = rankLabels(sparse, given);
  const size_t atOnce = GapFiller(sparse.lattice, given, ranked).next().end;
  ASSERT_GE(atOnce, 2u);
  for (size_t bad = 0; bad < atOnce; ++bad) {
    GapFiller filler(sparse.lattice, given, ranked);
    Image made = expected;
    std::mutex one;
    size_t others = 0;
    EXPECT_THROW(filler.fill(
                     [&](size_t n) {
                       return LabelSlice{sparse.values, layout, given.at[n]};
                     },
                     [&](const FilledGap& gap) {
                       if (gap.gap == bad) throw std::bad_alloc();
                       const std::lock_guard<std::mutex> lock(one);
                       paintGap(gap, ranked, layout, given.at[gap.gap] + 1, made.values);
                       ++others;
                     }),
                 std::bad_alloc);
    EXPECT_EQ(others, atOnce - 1) << bad;
    EXPECT_EQ(made.values, expected.values) << bad;
  }
}

/// Of wide gaps fewer are filled at once; the first one always.
TEST(FillGaps, WideGapsAreFewAtOnce) {
  ImageLattice lattice;
  lattice.size = openvdb::Coord(4, 4, 500);
  const GapFiller wide(lattice, {2, {0, 200, 400, 450}}, {0}), mixed(lattice, {2, {0, 30, 60, 90, 400}}, {0}),
      narrow(lattice, {2, {0, 2, 4, 6}}, {0});
  EXPECT_EQ(wide.next().end, 1u);
  EXPECT_EQ(mixed.next().end, 2u);
  EXPECT_EQ(narrow.next().end, 3u);
}

TEST(FillGaps, SlicesOutsideAreRefused) {
  const Image sparse = windingTubes(2);
  EXPECT_THROW(GapFiller(sparse.lattice, {2, {0}}, {0}), InputError);
  EXPECT_THROW(GapFiller(sparse.lattice, {2, {0, kSlices}}, {0}), InputError);
  EXPECT_THROW(GapFiller(sparse.lattice, {2, {3, 3}}, {0}), InputError);
  EXPECT_THROW(GapFiller(sparse.lattice, {3, {0, 3}}, {0}), InputError);
}

}  // namespace
}  // namespace slicemorph

// A gap of one slice, drawn by hand: what a pixel joins is known.
#include "engine/reconstruct/join_pieces.h"
#include "engine/reconstruct/fill_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace slicemorph {
namespace {

constexpr int kSide = 16;

/// Two given slices: a block of the label up to before x = `end` on the first; up to x = 7, and a speck at x = 10, on the
/// second.
struct Specks {
  explicit Specks(int end = 10) {
    Image image;
    image.lattice.size = openvdb::Coord(kSide, kSide, 3);
    std::vector<std::uint8_t> values(image.lattice.count(), 0);
    for (int j = 3; j < 8; ++j)
      for (int i = 3; i < 10; ++i) {
        if (i < end) values[image.lattice.index(i, j, 0)] = 5;
        if (i < 8) values[image.lattice.index(i, j, 2)] = 5;
      }
    values[image.lattice.index(10, 5, 2)] = 5;
    image.values = std::move(values);
    RankedSlices ranked = rankSlices(image, {2, {0, 2}});
    EXPECT_EQ(ranked.values[0], 5);
    plan = planSlices(std::move(ranked.stack), {});
  }
  /// The slice between them: the label in the block up to before x = `end`.
  static std::vector<int> between(int end) {
    std::vector<int> labels(kSide * kSide, 1);
    for (int j = 3; j < 8; ++j) std::fill_n(&labels[size_t(j * kSide + 3)], end - 3, 0);
    return labels;
  }
  std::vector<int> joined(std::vector<int> labels) const {
    joinPieces(plan, 0, {1.0}, labels);
    return labels;
  }
  SlicePlan plan;
};

TEST(JoinPieces, OnePixelTiesASpeckToTheRest) {
  const Specks specks;
  const std::vector<int> before = Specks::between(9), after = specks.joined(before);
  std::vector<size_t> changed;
  for (size_t i = 0; i < before.size(); ++i)
    if (after[i] != before[i]) changed.push_back(i);
  ASSERT_EQ(changed.size(), 1u);
  EXPECT_EQ(after[changed[0]], 0);
  EXPECT_EQ(changed[0] % kSide, 9u);
  EXPECT_NEAR(double(changed[0] / kSide), 5, 1);
}

TEST(JoinPieces, WhatTouchesAlreadyStays) {
  const Specks specks;
  EXPECT_EQ(specks.joined(Specks::between(10)), Specks::between(10));
}

/// The nearest of the label is two pixels further: one would not do.
TEST(JoinPieces, WhatOnePixelDoesNotJoinStays) {
  const Specks specks(7);
  EXPECT_EQ(specks.joined(Specks::between(6)), Specks::between(6));
}

/// The label of the plane on the other side counts, too.
TEST(JoinPieces, ThePlaneBeyondIsJoined) {
  const Specks specks;
  const std::vector<int> after = specks.joined(Specks::between(6));
  EXPECT_EQ(std::count(after.begin(), after.end(), 0), 5 * 3 + 1);
}

/// A hole in the label on a given slice, which the gap closes, is no piece to be joined: the space around comes last.
TEST(JoinPieces, NothingIsTakenFromLabelsBefore) {
  Specks specks;
  std::vector<int> full(kSide * kSide, 0);
  EXPECT_EQ(specks.joined(full), full);
}

}  // namespace
}  // namespace slicemorph

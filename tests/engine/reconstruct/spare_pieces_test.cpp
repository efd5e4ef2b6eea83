// Gaps drawn by hand: which pieces are too many is known.
#include "engine/reconstruct/spare_pieces.h"
#include "engine/reconstruct/fill_gaps.h"
#include "engine/reconstruct/slice_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace slicemorph {
namespace {

constexpr int kDrawnSide = 20;
const PixelBox kDrawnDomain{0, 0, kDrawnSide, kDrawnSide};

using Drawn = std::vector<int>;  ///< of one slice: 1 where the label is

void draw(Drawn& slice, const PixelBox& box) {
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) slice[kDrawnDomain.index(x, y)] = 1;
}
Drawn drawn(const std::vector<PixelBox>& boxes) {
  Drawn slice(kDrawnDomain.count(), 0);
  for (const PixelBox& box : boxes) draw(slice, box);
  return slice;
}

/// A gap of some slices between two on which a label is drawn.
struct DrawnGap {
  DrawnGap(const Drawn& a, const Drawn& b, int slices) {
    Image image;
    image.lattice.size = openvdb::Coord(kDrawnSide, kDrawnSide, slices + 2);
    std::vector<std::uint8_t> values(image.lattice.count(), 0);
    for (int y = 0; y < kDrawnSide; ++y)
      for (int x = 0; x < kDrawnSide; ++x) {
        values[image.lattice.index(x, y, 0)] = std::uint8_t(a[kDrawnDomain.index(x, y)]);
        values[image.lattice.index(x, y, slices + 1)] = std::uint8_t(b[kDrawnDomain.index(x, y)]);
      }
    image.values = std::move(values);
    RankedSlices ranked = rankSlices(image, {2, {0, slices + 1}});
    EXPECT_EQ(ranked.values[0], 1);
    plan = planSlices(std::move(ranked.stack), {});
    for (int k = 1; k <= slices; ++k) positions.push_back(k);
  }
  /// What becomes of slices between them.
  std::vector<Drawn> without(const std::vector<Drawn>& slices) const {
    std::vector<int> labels;
    for (const Drawn& slice : slices)
      for (int v : slice) labels.push_back(1 - v);  // ranks: the label is the smaller one
    dropSparePieces(plan, 0, positions, labels);
    std::vector<Drawn> result;
    for (size_t k = 0; k < slices.size(); ++k) {
      result.emplace_back();
      for (size_t i = 0; i < kDrawnDomain.count(); ++i)
        result[k].push_back(1 - labels[k * kDrawnDomain.count() + i]);
    }
    return result;
  }
  SlicePlan plan;
  std::vector<double> positions;
};

/// Pieces of the label, found by flooding.
int piecesIn(Drawn slice, bool corners) {
  int pieces = 0;
  for (size_t seed = 0; seed < slice.size(); ++seed) {
    if (!slice[seed]) continue;
    ++pieces;
    std::vector<size_t> open{seed};
    while (!open.empty()) {
      const int x = int(open.back() % kDrawnSide), y = int(open.back() / kDrawnSide);
      open.pop_back();
      for (int v = std::max(0, y - 1); v < std::min(kDrawnSide, y + 2); ++v)
        for (int u = std::max(0, x - 1); u < std::min(kDrawnSide, x + 2); ++u) {
          int& to = slice[kDrawnDomain.index(u, v)];
          if (to && (corners || u == x || v == y)) to = 0, open.push_back(kDrawnDomain.index(u, v));
        }
    }
  }
  return pieces;
}

}  // namespace

TEST(SlicePieces, AreWhatFloodingFinds) {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    Drawn slice(kDrawnDomain.count());
    for (int& v : slice) v = random() % 10 < 4;
    for (const bool corners : {false, true}) {
      std::vector<PieceRun> runs = findRuns(kDrawnDomain, slice.data());
      joinToPieces(runs, corners ? Touching::kCorners : Touching::kSides);
      std::set<std::uint32_t> pieces;
      for (const PieceRun& run : runs)
        if (run.label == 1) pieces.insert(run.piece);
      EXPECT_EQ(int(pieces.size()), piecesIn(slice, corners)) << round << corners;
    }
  }
}

TEST(SparePieces, WhatTheSlicesAllowStays) {
  const Drawn whole = drawn({{4, 4, 14, 12}}), parts = drawn({{4, 4, 8, 12}, {10, 4, 14, 12}});
  EXPECT_EQ(DrawnGap(whole, parts, 1).without({parts})[0], parts);
  EXPECT_EQ(DrawnGap(whole, whole, 1).without({whole})[0], whole);
}

TEST(SparePieces, ACutIsClosed) {
  // One block on both planes, two halves a pixel apart between them.
  const Drawn whole = drawn({{4, 4, 14, 12}}), cut = drawn({{4, 4, 8, 12}, {9, 4, 14, 12}});
  const Drawn after = DrawnGap(whole, whole, 1).without({cut})[0];
  EXPECT_EQ(piecesIn(after, false), 1);
  // Nothing is lost, and what is taken lies in the cut.
  for (int y = 0; y < kDrawnSide; ++y)
    for (int x = 0; x < kDrawnSide; ++x) {
      const size_t i = kDrawnDomain.index(x, y);
      EXPECT_TRUE(after[i] == cut[i] || (after[i] == 1 && x == 8)) << x << ' ' << y;
    }
}

TEST(SparePieces, ASpeckFarFromTheRestIsDropped) {
  const Drawn whole = drawn({{3, 3, 9, 9}}), speck = drawn({{3, 3, 9, 9}, {16, 15, 17, 17}});
  EXPECT_EQ(DrawnGap(whole, whole, 1).without({speck})[0], whole);
}

TEST(SparePieces, TouchingAtACornerIsTwoPieces) {
  const Drawn whole = drawn({{4, 4, 12, 10}}), corner = drawn({{4, 4, 12, 10}, {12, 10, 13, 11}});
  EXPECT_EQ(piecesIn(corner, true), 1);
  EXPECT_EQ(piecesIn(DrawnGap(whole, whole, 1).without({corner})[0], false), 1);
}

TEST(SparePieces, WhatNoPlaneHoldsIsTiedOrDropped) {
  // A block that becomes another elsewhere: what lies between them, held by neither, is a third.
  const Drawn a = drawn({{2, 2, 8, 8}}), b = drawn({{11, 11, 17, 17}});
  const Drawn between = drawn({{15, 3, 17, 5}});
  const std::vector<Drawn> after = DrawnGap(a, b, 3).without({a, between, b});
  EXPECT_EQ(after[0], a);
  EXPECT_EQ(after[2], b);
  // It is the label's only piece on its slice, which keeps one.
  EXPECT_EQ(piecesIn(after[1], false), 1);
  // Where the slice has another piece, it goes.
  const std::vector<Drawn> two = DrawnGap(a, a, 3).without({a, drawn({{2, 2, 8, 8}, {15, 3, 17, 5}}), a});
  EXPECT_EQ(two[1], a);
}

TEST(SparePieces, FilledGapsHaveNoMoreThanTheirSlices) {
  // Branches that come and go on given slices: in between there are never more of them than on both sides.
  std::mt19937 random(3);
  for (int round = 0; round < 10; ++round) {
    Image image;
    const int every = 4, count = 13;
    image.lattice.size = openvdb::Coord(kDrawnSide, kDrawnSide, count);
    std::vector<std::uint8_t> values(image.lattice.count(), 0);
    std::vector<Drawn> given;
    GivenSlices at{2, {}};
    for (int k = 0; k < count; k += every) {
      std::vector<PixelBox> boxes;
      for (unsigned n = 1 + random() % 4; n > 0; --n) {
        const int x = 1 + int(random() % 13), y = 1 + int(random() % 13);
        boxes.push_back({x, y, x + 1 + int(random() % 5), y + 1 + int(random() % 5)});
      }
      given.push_back(drawn(boxes)), at.at.push_back(k);
      for (size_t i = 0; i < kDrawnDomain.count(); ++i)
        values[size_t(k) * kDrawnDomain.count() + i] = std::uint8_t(given.back()[i]);
    }
    image.values = std::move(values);
    const Image dense = interpolateLabels(image, at);
    const auto& filled = std::get<std::vector<std::uint8_t>>(dense.values);
    for (int k = 0; k < count; ++k) {
      if (k % every == 0) continue;
      const std::uint8_t* from = &filled[size_t(k) * kDrawnDomain.count()];
      const Drawn slice(from, from + kDrawnDomain.count());
      EXPECT_LE(piecesIn(slice, true), std::max(piecesIn(given[size_t(k / every)], true),
                                                piecesIn(given[size_t(k / every + 1)], true)))
          << round << ' ' << k;
      EXPECT_GE(piecesIn(slice, true), 1) << round << ' ' << k;
    }
  }
}

}  // namespace slicemorph

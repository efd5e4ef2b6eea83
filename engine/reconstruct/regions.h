#pragma once

#include "engine/reconstruct/slice_motion.h"

namespace slicemorph {

/// One connected piece (8 neighbours) of a label on a plane.
struct LabelRegion {
  PixelBox box;
  size_t count = 0;    ///< pixels
  float x = 0, y = 0;  ///< centroid, pixels
  float depth = 0;     ///< greatest score, world units
};

/// Pixels [x0, x1) of one row that are one region's.
struct RegionRun {
  int y, x0, x1, region;
};

struct LabelRegions {
  std::vector<LabelRegion> regions;
  std::vector<RegionRun> runs;  ///< row by row, from left to right

  /// The region that holds a pixel; -1: none.
  int at(int x, int y) const;
};

LabelRegions findRegions(const LabelScore& score);

/// A region on either plane.
struct RegionPair {
  int a, b;
};

/// Pairs the regions that meet none of their label's once the motion has carried them, by least centroid
/// distance plus the difference of their radii, nearest first; a label none of whose regions meet keeps at
/// least one pair, however far.
std::vector<RegionPair> pairRegions(const LabelRegions& ra, const LabelRegions& rb, const SliceMotion& motion,
                                    const ScoreStack& stack, float gap);

/// The score of one region alone.
LabelScore regionScore(const LabelScore& score, const LabelRegions& regions, int region,
                       const ScoreStack& stack);

}  // namespace slicemorph

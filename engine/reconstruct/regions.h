#pragma once

#include "engine/reconstruct/slice_motion.h"

namespace slicemorph {

/// One connected piece (8 neighbours) of a label on a plane.
struct LabelRegion {
  PixelBox box;
  size_t count = 0;    ///< pixels
  float x = 0, y = 0;  ///< centroid, pixels
  float depth = 0;     ///< largest score, world units
};

/// The pixels [x0, x1) of one row that belong to one region.
struct RegionRun {
  int y, x0, x1, region;
};

struct LabelRegions {
  std::vector<LabelRegion> regions;
  std::vector<RegionRun> runs;  ///< row by row, from left to right

  /// Index of the region that contains a pixel; -1: none.
  int at(int x, int y) const;
};

LabelRegions findRegions(const LabelScore& score);

/// Indices of two matching regions, on the first and the second plane of a gap.
struct RegionPair {
  int a, b;
};

/// Pairs regions of one label that overlap none of the label's regions on the other plane once the motion has
/// carried them; nearest first, by the distance of their centroids plus the difference of their radii. A
/// label none of whose regions overlap gets at least one pair, however far apart. `gap`: world units.
std::vector<RegionPair> pairRegions(const LabelRegions& ra, const LabelRegions& rb, const SliceMotion& motion,
                                    const ScoreStack& stack, float gap);

/// The score of one region alone.
LabelScore regionScore(const LabelScore& score, const LabelRegions& regions, int region,
                       const ScoreStack& stack);

}  // namespace slicemorph

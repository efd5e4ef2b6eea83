#pragma once

#include "engine/reconstruct/slice_gap.h"
#include "engine/reconstruct/slice_moment.h"

namespace slicemorph {

/// Pixel positions on the four planes around a gap.
struct PlanePositions {
  float x[4], y[4];
};

/// The motion, in pixels per gap, of what is at (x, y) at fraction `t` of the gap.
SliceMotion::Vector motionAt(const SlicePlan& plan, const Moment& m, float t, float x, float y);

/// Positions on the four planes of what is at (x, y) half way through the gap.
PlanePositions positionsOf(const SlicePlan& plan, const Moment& m, float x, float y);
/// The same for a given motion `v` across the gap.
PlanePositions positionsOf(const SlicePlan& plan, const Moment& m, float x, float y, SliceMotion::Vector v);

/// How far, in pixels, a path is from the straight one at a moment, for what is at these positions on the planes.
SliceMotion::Vector bendOf(const PlanePositions& p, const PathBend& path);

/// By how much a label's score drops towards a plane (index 0 to 3) on which the label is missing.
float fall(const GapLabel& l, int plane);

/// A label's scores on the four planes; 0 where the label is missing.
void readScores(const GapLabel& l, const PlanePositions& p, float* s);
/// Fills in the planes where the label is missing, and levels off all scores.
void completeScores(const GapLabel& l, const Moment& m, float* s);

/// A label's score at pixel (x, y), including its own travellers and those of other labels.
float wholeScore(const SlicePlan& plan, const GapLabel& l, const Moment& m, float x, float y);

/// The score of a traveller at fraction `t` of its gap.
float scoreOf(const Traveller& traveller, const ScoreStack& stack, float t, float level, float x, float y);

}  // namespace slicemorph

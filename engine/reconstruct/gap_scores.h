#pragma once

#include "engine/reconstruct/slice_gap.h"
#include "engine/reconstruct/slice_moment.h"

namespace slicemorph {

/// Where pixels lie on the four planes.
struct PlanePositions {
  float x[4], y[4];
};

/// Where what is at a point half way came from at part `t` of the gap: the motion that carries it, pixels a gap.
SliceMotion::Vector motionAt(const SlicePlan& plan, const Moment& m, float t, float x, float y);

/// Where on the planes lies what is at (x, y) half way ...
PlanePositions positionsOf(const SlicePlan& plan, const Moment& m, float x, float y);
/// ... and moves by `v` from plane to plane.
PlanePositions positionsOf(const SlicePlan& plan, const Moment& m, float x, float y, SliceMotion::Vector v);

/// What a label's score falls by to a plane (of the four) where it is not.
float fall(const GapLabel& l, int plane);

/// A label's scores on the four planes; 0 where it is not.
void readScores(const GapLabel& l, const PlanePositions& p, float* s);
/// Fills in the planes where the label is not, and levels off.
void completeScores(const GapLabel& l, const Moment& m, float* s);

/// A label's score, travellers of its own and of others considered.
float wholeScore(const SlicePlan& plan, const GapLabel& l, const Moment& m, float x, float y);

/// A traveller's at part `t` of its gap.
float scoreOf(const Traveller& traveller, const ScoreStack& stack, float t, float level, float x, float y);

}  // namespace slicemorph

#pragma once

#include "engine/slices/slice_stack.h"

namespace slicemorph {

/// Closed contour in the slice plane: outer ones counter-clockwise, holes clockwise.
struct Contour {
  std::vector<Vec2d> points;  ///< chart units; the first is not repeated
  double area = 0;            ///< signed: negative for holes
  Vec2d centroid{0, 0};
  int parent = -1;  ///< the contour directly around this one, -1: none
  bool hole() const { return area < 0; }
};

/// First and second moments of a slice's inside.
struct SliceMoments {
  double area = 0;
  Vec2d mean{0, 0};
  double xx = 0, xy = 0, yy = 0;  ///< covariance
};

/// Zero contours by marching squares ([LC87], in the plane); ambiguous cells are resolved by
/// the value at their centre, so neighbours agree. Contours of less than four pixels' area are dropped as
/// noise.
std::vector<Contour> traceContours(const SliceImage& image, const SlicePlanes& planes);

SliceMoments momentsOf(const std::vector<Contour>& contours);

/// `count` points at equal steps of arc length, the first at the contour's own first point.
std::vector<Vec2d> resample(const Contour& contour, int count);

/// Whether a point lies inside a closed polygon (even-odd rule).
bool contains(const std::vector<Vec2d>& polygon, const Vec2d& p);

}  // namespace slicemorph

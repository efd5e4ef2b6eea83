#pragma once

#include "engine/slices/slice_stack.h"

namespace slicemorph {

/// Closed contour in a slice plane: outer ones counter-clockwise, holes clockwise.
struct Contour {
  std::vector<Vec2d> points;  ///< chart units; the first is not repeated
  double area = 0;            ///< signed: negative for holes
  Vec2d centroid{0, 0};
  int parent = -1;  ///< index of the smallest contour around this one; -1: none
  bool hole() const { return area < 0; }
};

/// Moments of a slice's inside, chart units.
struct SliceMoments {
  double area = 0;
  Vec2d mean{0, 0};
  double xx = 0, xy = 0, yy = 0;  ///< covariance
};

/// Zero contours by marching squares (the plane case of [LC87]); ambiguous cells are resolved by the
/// mean of their corners. Contours of less than `least` pixels' area are dropped as noise, as are those
/// that the image's border cuts.
std::vector<Contour> traceContours(const SliceImage& image, const SlicePlanes& planes, double least = 4);

/// Moments of the area between contours, holes subtracted; all zero if there is none.
SliceMoments momentsOf(const std::vector<Contour>& contours);

/// `count` points at equal steps of arc length, from the contour's first point on.
std::vector<Vec2d> resample(const Contour& contour, int count);

/// Whether a point lies inside a closed polygon (even-odd rule).
bool contains(const std::vector<Vec2d>& polygon, const Vec2d& p);

}  // namespace slicemorph

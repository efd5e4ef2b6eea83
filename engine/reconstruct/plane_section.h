#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// An object's cross-section with one plane: the edges of its region, in no particular order (even-odd rule).
struct PlaneSection {
  PlaneContours frame;  ///< without loops
  struct Edge {
    Vec2d a, b;
  };
  std::vector<Edge> edges;
};

/// The region that a plane's contours enclose. By the even-odd rule nested contours are holes, and so is what
/// a self-intersecting contour encloses twice. A line that a contour runs along twice, in and out (a
/// keyhole), is no edge; contours that intersect each other are joined; of duplicate contours one is kept.
/// Notes about this are about `subject`. `tolerance`: world units, below which two points are the same.
PlaneSection sectionOf(const PlaneContours& plane, double tolerance, const std::string& subject,
                       Notes& notes);

/// Signed distance to a section's edges on a grid of pixels, negative inside; computed after [Dan80], with
/// exact distances to the edges that are propagated.
struct PlaneImage {
  int width = 0, height = 0;
  Vec2d low{0, 0};  ///< plane units: centre of pixel (0, 0)
  double pixel = 1;
  std::vector<float> distance;
  std::vector<int> nearest;  ///< index of the nearest edge

  Vec2d position(int i, int j) const { return low + pixel * Vec2d(i, j); }
  /// Bilinear value; outside the image the value at its border plus the distance to it. 1e30 for a section
  /// without edges.
  double at(const Vec2d& p) const;
};
PlaneImage distanceImage(const PlaneSection& section, double pixel, double margin);

}  // namespace slicemorph

#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// What a plane says about an object: the edges of the region inside, in no order (inside by the even-odd
/// rule).
struct PlaneSection {
  PlaneContours frame;  ///< without loops
  struct Edge {
    Vec2d a, b;
  };
  std::vector<Edge> edges;
};

/// The region of a plane's contours. Nested contours are holes by the even-odd rule, as is what a contour
/// that crosses itself encloses twice; a line that a contour runs in and out along (a keyhole) is no edge;
/// contours that cross each other are joined; of contours given twice one is taken. The notes that say so are
/// about `subject`. `tolerance`: world units, below which two points are the same.
PlaneSection sectionOf(const PlaneContours& plane, double tolerance, const std::string& subject,
                       Notes& notes);

/// Signed distance to a section's edges on a grid of pixels, negative inside ([Dan80], with exact
/// distances to the edge handed on).
struct PlaneImage {
  int width = 0, height = 0;
  Vec2d low{0, 0};  ///< plane units: centre of pixel (0, 0)
  double pixel = 1;
  std::vector<float> distance;
  std::vector<int> nearest;  ///< the edge

  Vec2d position(int i, int j) const { return low + pixel * Vec2d(i, j); }
  /// Bilinear; outside the image at least the distance to it. A section without edges is far from everything.
  double at(const Vec2d& p) const;
};
PlaneImage distanceImage(const PlaneSection& section, double pixel, double margin);

}  // namespace slicemorph

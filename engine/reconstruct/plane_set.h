#pragma once

#include "engine/reconstruct/plane_section.h"
#include "slicemorph/note.h"

namespace slicemorph {

struct NextPlane {
  double distance = 0;  ///< world units; infinite: there is none
  int plane = -1;
};

/// The planes of an object, prepared: cleaned regions, edges no longer than `step`, signed distance images.
struct PlaneSet {
  std::vector<PlaneSection> sections;
  std::vector<PlaneImage> images;  ///< one per section, with pixels of `step`
  openvdb::BBoxd box;              ///< of all edges, world space
  double gap = 0;  ///< usual distance from a contour to the next plane along the normal, world units
  double step = 0;
  double bridgedGaps = 3;  ///< as ContourSurfaceOptions

  Vec3d world(int plane, const Vec2d& p) const { return sections[plane].frame.toWorld(p); }
  /// Distance from a point of a plane to another plane, along `side` (1 or -1) times the first plane's
  /// normal; negative: the other plane is not met.
  double crossing(int plane, int other, const Vec3d& p, int side) const;
  /// The nearest other plane from a point of a plane, along `side` (1 or -1) times its normal.
  NextPlane nextPlane(int plane, const Vec3d& p, int side) const;
  /// Whether the object must be closed on that side of a plane at a point inside, because no near plane says
  /// anything there.
  bool endsAt(int plane, const Vec3d& p, int side) const;
  /// How far beyond the plane the object may reach there, world units.
  double capHeight(int plane, const Vec3d& p, int side) const;
  std::vector<char> outermost;  ///< by plane * 2 + (side > 0): no contour is beyond it
  /// Indexed as `outermost`: near the whole of the plane's image another plane follows. Set by makeImages.
  std::vector<char> bridged;
};

struct Sampling {
  double edge = 0, gap = 0;  ///< medians, world units
  double extent = 0;         ///< longest side of the contours' bounding box, world units
};

/// Cleans the regions; `notes` receives what was repaired. Throws GeometryError unless at least two planes
/// have contours.
PlaneSet cleanPlanes(const ContourSet& set, Notes& notes, double bridgedGaps = 3);
Sampling samplingOf(const PlaneSet& planes);
/// Splits the edges and computes the distance images. `step`: pixel size and longest edge, world units.
void makeImages(PlaneSet& planes, double step);

}  // namespace slicemorph

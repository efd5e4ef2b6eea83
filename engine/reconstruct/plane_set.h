#pragma once

#include "engine/reconstruct/plane_section.h"
#include "slicemorph/note.h"

namespace slicemorph {

struct NextPlane {
  double distance = 0;  ///< infinite: there is none
  int plane = -1;
};

/// The planes of an object, made ready: regions cleaned, edges no longer than `step`, signed distance images.
struct PlaneSet {
  std::vector<PlaneSection> sections;
  std::vector<PlaneImage> images;  ///< one a section, pixels of `step`
  openvdb::BBoxd box;              ///< of all edges, world
  double gap = 0;                  ///< usual distance from a contour to the next plane along the normal
  double step = 0;

  Vec3d world(int plane, const Vec2d& p) const { return sections[plane].frame.toWorld(p); }
  /// How far along `side` times the plane's normal a point of it is from another plane; negative: it is not
  /// met.
  double crossing(int plane, int other, const Vec3d& p, int side) const;
  /// The next plane from a point of a plane, along `side` (1 or -1) times its normal.
  NextPlane nextPlane(int plane, const Vec3d& p, int side) const;
  /// Whether the object has to be closed on that side of a plane at a point inside: nothing is known there
  /// any more.
  bool endsAt(int plane, const Vec3d& p, int side) const;
  /// How far beyond the plane it may then reach.
  double capHeight(int plane, const Vec3d& p, int side) const;
  std::vector<char> outermost;  ///< by plane * 2 + (side > 0): no contour lies beyond it
  std::vector<char>
      bridged;  ///< as outermost: all of its image has another plane near beyond it, by makeImages
};

struct Sampling {
  double edge = 0, gap = 0;  ///< medians, world units
  double extent = 0;         ///< longest side of the contours' box
};

/// Cleans the regions; `notes` takes what had to be repaired. Throws GeometryError without contours on two
/// planes.
PlaneSet cleanPlanes(const ContourSet& set, Notes& notes);
Sampling samplingOf(const PlaneSet& planes);
/// Splits the edges and makes the images.
void makeImages(PlaneSet& planes, double step);

}  // namespace slicemorph

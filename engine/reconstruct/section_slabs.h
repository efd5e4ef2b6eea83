#pragma once

#include "engine/sections/section_plane.h"

namespace slicemorph {

/// A position between two slices.
struct BetweenSections {
  size_t slab = 0;      ///< between planes slab and slab + 1
  Vec3d first, second;  ///< the corresponding points on the two planes, in pixels (i, j); z is unused
  double share = 0;     ///< weight of the second; below 0 or above 1 beyond the end planes
  double beyond = 0;    ///< world units beyond half the gap outside an end plane; -infinity between planes
};

/// The space between consecutive slices.
class SectionSlabs {
 public:
  /// `planes`: in order, two or more; they must outlive this. `reach`: how far positions are found beyond
  /// half a gap outside the end planes, world units. Throws InputError for fewer than two planes, and where
  /// consecutive planes are too oblique to each other.
  SectionSlabs(const std::vector<SectionPlane>& planes, double reach);

  /// World box of all positions that find() may find.
  const openvdb::BBoxd& box() const { return box_; }
  /// The slabs that may contain a point of a sphere (world space).
  void near(const Vec3d& centre, double radius, std::vector<size_t>& slabs) const;
  /// Whether one of these slabs contains a world point; if so, sets `position`. Of several slabs, the one
  /// whose images have the point nearest to their centres is used.
  bool find(const Vec3d& p, const std::vector<size_t>& slabs, BetweenSections& position) const;

 private:
  struct Slab {
    Vec3d along;      ///< unit vector from the first plane to the second, bisecting their normals
    double slope[2];  ///< along * normal of each plane
    double before = 0, after = 0;  ///< how far the slab extends beyond its planes, world units
    /// at the ends of the stack: half the slab's thickness, measured at its middle
    double halfGap[2] = {0, 0};
  };
  bool locate(size_t slab, const Vec3d& p, BetweenSections& position) const;

  const std::vector<SectionPlane>& planes_;
  std::vector<Slab> slabs_;
  openvdb::BBoxd box_;
};

}  // namespace slicemorph

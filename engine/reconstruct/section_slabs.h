#pragma once

#include "engine/sections/section_plane.h"

namespace slicemorph {

/// A place between two slices.
struct BetweenSections {
  size_t slab = 0;      ///< between planes slab and slab + 1
  Vec3d first, second;  ///< the points of the two planes that it lies between; z is unused: pixels (i, j)
  double share = 0;     ///< of the second; below 0 or above 1 beyond the end planes
  double beyond = 0;    ///< world units beyond half the gap outside of an end plane; negative elsewhere
};

/// The space between slices that follow each other.
class SectionSlabs {
 public:
  /// `planes`: in their order, two or more. `reach`: how far beyond half the gap outside of the end planes
  /// places are found, world units.
  SectionSlabs(const std::vector<SectionPlane>& planes, double reach);

  /// World box of all that may be found.
  const openvdb::BBoxd& box() const { return box_; }
  /// Slabs that may hold a place in a sphere.
  void near(const Vec3d& centre, double radius, std::vector<size_t>& slabs) const;
  /// Whether one of these slabs holds a place, and where in it.
  bool find(const Vec3d& p, const std::vector<size_t>& slabs, BetweenSections& position) const;

 private:
  struct Slab {
    Vec3d along;                   ///< unit, from the first plane to the second, evenly on both
    double slope[2];               ///< along * the planes' normals
    double before = 0, after = 0;  ///< how far beyond the planes it goes, world units
    double halfGap[2] = {0, 0};    ///< half the offset through it at an end of the stack, in the middle
  };
  bool locate(size_t slab, const Vec3d& p, BetweenSections& position) const;

  const std::vector<SectionPlane>& planes_;
  std::vector<Slab> slabs_;
  openvdb::BBoxd box_;
};

}  // namespace slicemorph

#pragma once

#include "slicemorph/slicemorph.h"

namespace slicemorph {

struct RadialOptions {
  /// 0: points move along straight lines. Else along Hermite cubics that leave the first object and reach the second
  /// along their outward normals: the length of these tangents, in mean radii of the two objects.
  double tangent = 0;
};

/// Morph of objects that are star-shaped, by their radii [KCP92]: all surface points are seen from a centre, and those
/// in the same direction belong together. The centre is the centroid, or where that does not see the whole surface a
/// point that does.
class RadialMorph {
 public:
  /// `voxelSize`: world units; directions are so close to each other that no two neighbours are further apart than
  /// that. Throws InputError for an object that is not star-shaped, for tangents with other than two objects, and where
  /// more directions are needed than kMostRays.
  RadialMorph(const std::vector<Object>& objects, double voxelSize, const RadialOptions& options = {});
  /// A level set named "surface". Throws InputError unless there is one weight per object, and where weights below 0
  /// leave no positive radius.
  FloatGrid::Ptr frame(const Weights& weights) const;

  static constexpr double kMostRays = 8e6;  ///< of each object; a ray takes 12 bytes, with tangents 24

 private:
  /// An object as it is seen from its centre.
  struct Star {
    Vec3d centre{0, 0, 0};
    std::vector<openvdb::Vec3s> reach;   ///< per direction: from the centre to the surface
    std::vector<openvdb::Vec3s> normal;  ///< per direction: of the surface, outwards; none without tangents
  };
  std::vector<Star> stars_;
  int rings_ = 0, around_ = 0;
  double voxelSize_ = 0, tangent_ = 0;  ///< both world units
};

}  // namespace slicemorph

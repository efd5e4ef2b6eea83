#pragma once

#include "engine/spine/chart.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

struct CylindricalOptions {
  /// Length of the cap at either end of an axis, as a share of half its length; 0: the object's mean radius, and half of
  /// half the length at most.
  double cap = 0;
};

/// Morph of objects that are star-shaped about an axis that bends [LV94]. Between two caps a surface point is seen from
/// the axis at a right angle, in the caps from the middle of their foot in all directions. Points at the same share of the
/// way along the axes and in the same direction belong together; the axes' bends and lengths, and the distances from
/// them, are blended. The axes are the spines that the slice method finds, or straight ones for all where an object is
/// as wide as long.
class CylindricalMorph {
 public:
  /// `voxelSize`: world units; neighbouring rays meet surfaces about that far from each other. Throws InputError for
  /// an object that is not star-shaped about its axis, for caps that meet, and where more rays are needed than
  /// kMostRays.
  CylindricalMorph(const std::vector<Object>& objects, double voxelSize,
                   const CylindricalOptions& options = {});
  /// A level set named "surface". Throws InputError unless there is one weight per object.
  FloatGrid::Ptr frame(const Weights& weights) const;

  static constexpr double kMostRays = 8e6;  ///< of each object; a ray takes 4 bytes

 private:
  /// An object as it is seen from its axis.
  struct Cylinder {
    Chart chart;
    double middle = 0;          ///< half the length of the axis without the caps, world units
    std::vector<float> radius;  ///< per ray: from the axis to the surface
  };
  std::vector<Cylinder> cylinders_;
  int capRings_ = 0, middleRings_ = 0, around_ = 0;
  double voxelSize_ = 0;
};

}  // namespace slicemorph

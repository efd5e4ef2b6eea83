#pragma once

#include "engine/match/limb_groups.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// The user's features as the matching uses them, in the objects' chart coordinates.
struct FeaturePoints {
  std::vector<Correspondence> marks;           ///< of points and disks
  std::vector<Correspondence> lines;           ///< of lines: points along and around them, as of limbs
  std::vector<std::vector<PlacedLimb>> limbs;  ///< per object: the lines; their `middle` repeats `chart`
};

/// `features`: of the objects of `fields`, world units. Lines that join end to end on all objects become one.
FeaturePoints placeFeatures(const std::vector<Feature>& features, const Fields& fields,
                            const std::vector<Chart>& charts);

/// The point at a share (0 to 1) of a polyline's length, to the nearest thousandth of it.
Vec3d pointAlong(const std::vector<Vec3d>& line, double share);

/// Whether the outer half of a limb lies along one of the lines of the same object.
bool isPrescribedBy(const PlacedLimb& limb, const std::vector<PlacedLimb>& lines);

struct FeaturesInReach {
  std::vector<Feature> features;
  Notes notes;  ///< one warning per feature left out
};

/// The features without those that lie far from every object's surface and so cannot steer the map there.
FeaturesInReach featuresInReach(const std::vector<Feature>& features, const Fields& fields);

/// One warning for each feature that a map misses, naming the feature with which it conflicts most. `size`:
/// of the objects, chart units.
Notes contradictions(const std::vector<Feature>& features, const std::vector<Chart>& charts,
                     const Displacements& map, double size);

}  // namespace slicemorph

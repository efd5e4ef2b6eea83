#pragma once

#include "engine/match/limb_groups.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// A user's features as the matching takes them: of the objects, chart coordinates.
struct FeaturePoints {
  std::vector<Correspondence> marks;           ///< of points and disks
  std::vector<Correspondence> lines;           ///< of lines: along them and around, swinging like limbs
  std::vector<std::vector<PlacedLimb>> limbs;  ///< per object, the lines without their middle places
};

/// `features`: of the objects of `fields`. Lines that follow each other on all objects are one.
FeaturePoints placeFeatures(const std::vector<Feature>& features, const Fields& fields,
                            const std::vector<Chart>& charts);

/// The place at a share (0 to 1) of a polyline's length.
Vec3d placeAlong(const std::vector<Vec3d>& line, double share);

/// Whether a limb lies along a line of the same object.
bool isPrescribedBy(const PlacedLimb& limb, const std::vector<PlacedLimb>& lines);

struct FeaturesInReach {
  std::vector<Feature> features;
  Notes notes;  ///< of those that are left out
};

/// The features without those that lie far from every object's surface, which have nothing to hold on to.
FeaturesInReach featuresInReach(const std::vector<Feature>& features, const Fields& fields);

/// What features a map does not meet although it was asked to, and with which other ones they are at odds,
/// one warning each.
Notes contradictions(const std::vector<Feature>& features, const std::vector<Chart>& charts,
                     const Displacements& map, double size);

}  // namespace slicemorph

#pragma once

#include "engine/contours/contours.h"

#include <string>

namespace slicemorph {

/// An object's outlines on parallel slices through the middles of equally thick slabs, from end to end.
struct OutlineStack {
  Chart chart;               ///< straight, in world units: z0 runs across the slices
  double low = 0, high = 0;  ///< ends of the object along z0
  std::vector<std::vector<Contour>> slices;
};

/// How an object is cut.
struct OutlineCut {
  int slices = 96;
  double pixel = 0;    ///< world units
  std::string method;  ///< for the message of InputError
};

/// Throws InputError where the slices would have more than 2^28 pixels.
OutlineStack cutOutlines(const DistanceField& field, const Chart& chart, const OutlineCut& cut);

/// Outlines of the same part on one slice of all objects.
struct OutlineGroup {
  std::vector<const Contour*> of;  ///< per object; null: it has no such part
  std::vector<Vec2d> centre;       ///< per object: of its outline, or where that would be
};

/// Groups the outlines of slice `slice` of all objects: each object's are assigned to those of the object that has most,
/// by the least sum of distances between centroids, seen from the middle of the slice; holes to holes. What has no
/// partner grows out of a point.
std::vector<OutlineGroup> groupOutlines(const std::vector<OutlineStack>& objects, size_t slice);

/// Closed polygons of one slice, even-odd rule; x, y of the chart.
using SliceLoops = std::vector<std::vector<Vec2d>>;

/// A shape given by its loops on slices through the middles of equal slabs from `low` to `high`.
struct LoopStack {
  Chart chart;
  double low = 0, high = 0;
  std::vector<SliceLoops> slices;
  std::string method;  ///< for the message of InputError
};

/// Level set named "surface": signed distances within the slices, linear from slice to slice; where a slice is empty, the
/// shape ends on the way to it. The first and the last slab are closed by flat ends. Throws InputError for too many
/// voxels.
FloatGrid::Ptr surfaceOfLoops(const LoopStack& stack, double voxelSize);

}  // namespace slicemorph

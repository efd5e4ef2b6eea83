#pragma once

#include "engine/frame/align.h"
#include "engine/match/displacements.h"

namespace slicemorph {

/// Paths of contour points between objects that are not straight. The map carries the points of every
/// object's contours to all other objects; an in-between's contours are blended by Hermite cubics or
/// intrinsically, and the space around follows by a smooth fitted field.
class ContourPaths {
 public:
  /// `kind`: not kLinear. `slices`: number per object. Only (x, y) in the slices changes; positions along the
  /// spine are left to the charts and the map.
  ContourPaths(ContourPath kind, const Displacements& map, const Fields& fields,
               const std::vector<Chart>& charts, int slices);

  /// The in-between's offset from the linear path at each node of `lattice` (in the middle space), chart
  /// units; zero at the objects themselves.
  VectorField offsets(const Weights& weights, const Lattice& lattice) const;

 private:
  /// A closed contour, carried to every object.
  struct Loop {
    std::vector<Vec3d> middle;                    ///< middle space
    std::vector<std::vector<openvdb::Vec2d>> at;  ///< per object: (x, y)
  };
  ContourPath kind_;
  Lattice lattice_;  ///< of the fitted offsets
  std::vector<Loop> loops_;
};

/// Blends closed polygons with equally many points [SGWM93]: weighted means of edge lengths and
/// turning angles, closed by the least change of lengths, then rotated and moved to fit the
/// weighted mean of the points.
std::vector<openvdb::Vec2d> intrinsicBlend(const std::vector<std::vector<openvdb::Vec2d>>& polygons,
                                           const Weights& weights);

/// Blends the points along cubics that start and end at right angles to the polygons.
std::vector<openvdb::Vec2d> hermiteBlend(const std::vector<std::vector<openvdb::Vec2d>>& polygons,
                                         const Weights& weights);

}  // namespace slicemorph

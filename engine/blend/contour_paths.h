#pragma once

#include "engine/frame/align.h"
#include "engine/match/displacements.h"

namespace slicemorph {

/// Ways of the contours from object to object that are not straight. Every object's slices are cut and their
/// contours' points found on all other objects by the map; an in-between's contours then lie where Hermite's
/// or the intrinsic way leads, and the space around follows smoothly.
class ContourPaths {
 public:
  /// `kind`: not kLinear. `slices`: per object. Bends and lengths along the spine are the charts' matter.
  ContourPaths(ContourPath kind, const Displacements& map, const Fields& fields,
               const std::vector<Chart>& charts, int slices);

  /// How far from the straight way's place an in-between has what is at each node of a lattice, chart units;
  /// none at the objects themselves.
  VectorField offsets(const Weights& weights, const Lattice& lattice) const;

 private:
  /// A closed contour as every object has it.
  struct Loop {
    std::vector<Vec3d> middle;                    ///< middle space
    std::vector<std::vector<openvdb::Vec2d>> at;  ///< per object: (x, y)
  };
  ContourPath kind_;
  Lattice lattice_;  ///< of the fitted offsets
  std::vector<Loop> loops_;
};

/// Points that lie between closed polygons of equally many points, by the weights: the mean of their edge
/// lengths and turning angles, closed by the least change of lengths, turned and placed as the mean of the
/// points. After [SGWM93].
std::vector<openvdb::Vec2d> intrinsicBlend(const std::vector<std::vector<openvdb::Vec2d>>& polygons,
                                           const Weights& weights);

/// The same on cubics that leave and reach every polygon at right angles.
std::vector<openvdb::Vec2d> hermiteBlend(const std::vector<std::vector<openvdb::Vec2d>>& polygons,
                                         const Weights& weights);

}  // namespace slicemorph

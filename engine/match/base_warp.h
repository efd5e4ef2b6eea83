#pragma once

#include "engine/contours/contours.h"
#include "engine/match/displacements.h"

namespace slicemorph {

/// Contours of every slice of one object.
using ContourStack = std::vector<std::vector<Contour>>;

/// Per-slice affine map: one object's slice onto the middle slice.
struct SliceAffine {
  Vec2d mean{0, 0};
  double xx = 1, xy = 0, yy = 1;  ///< symmetric square root of the covariance
};

/// The base warp: every slice's mean and symmetric square root of its covariance, smoothed along the spine
/// over about four slices. An object without anything on a slice takes the nearest slices' values.
struct BaseWarp {
  std::vector<double> z0;                         ///< of the middle slices
  std::vector<std::vector<double>> place;         ///< per object: z0 of its slice that belongs to each
  std::vector<std::vector<SliceAffine>> objects;  ///< per object, per slice
  std::vector<SliceAffine> middle;                ///< their mean, per slice
};

/// `place`: as in BaseWarp.
BaseWarp makeBaseWarp(const std::vector<ContourStack>& stacks, const SlicePlanes& planes,
                      const std::vector<std::vector<double>>& place);

/// The base warp as displacements; fades to nothing from the edge of `box` (where the objects are) to the
/// lattice's.
Displacements baseDisplacements(const BaseWarp& base, const Lattice& lattice, const openvdb::BBoxd& box);

/// Object point on slice `i` -> middle point.
Vec2d toMiddle(const BaseWarp& base, size_t object, size_t slice, const Vec2d& p);

}  // namespace slicemorph

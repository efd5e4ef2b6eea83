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

/// The base warp: every slice's mean and the symmetric square root of its covariance, smoothed along
/// the spine with a Gaussian of four slices. A slice on which an object has nothing takes the
/// nearest slices' values.
struct BaseWarp {
  std::vector<double> z0;                         ///< of the middle slices, chart units
  std::vector<std::vector<double>> position;      ///< per object and middle slice: z0 of the object's slice
  std::vector<std::vector<SliceAffine>> objects;  ///< per object, per slice
  std::vector<SliceAffine> middle;                ///< their mean, per slice
};

/// `position`: as in BaseWarp.
BaseWarp makeBaseWarp(const std::vector<ContourStack>& stacks, const SlicePlanes& planes,
                      const std::vector<std::vector<double>>& position);

/// The base warp as displacements on a lattice. They fall linearly to zero from the faces of `box` (which
/// holds the objects) to those of the lattice.
Displacements baseDisplacements(const BaseWarp& base, const Lattice& lattice, const openvdb::BBoxd& box);

/// Maps a point (x, y) on an object's slice to the middle slice, chart units.
Vec2d toMiddle(const BaseWarp& base, size_t object, size_t slice, const Vec2d& p);

}  // namespace slicemorph

#pragma once

#include "engine/reconstruct/plane_set.h"
#include "engine/reconstruct/thin_plate.h"

namespace slicemorph {

/// Half width, in nodes, of the band around the surface that is solved for on fine lattices. Chosen by hand;
/// the stencil of the bending energy reaches two nodes.
constexpr double kBandNodes = 5;

/// Whether a lattice is small enough to be solved as a whole.
bool isSolvedWhole(const Lattice& lattice);

/// Per plane and edge: the share (0 to 1) of the function's gradient that is in the plane.
using PlaneSlopes = std::vector<std::vector<float>>;

/// The conditions that the planes impose on the function: 0 on the contours, the distances in the planes near
/// them (at every `stride`-th pixel), and outside beyond the planes where the object ends.
std::vector<PlateDatum> plateData(const PlaneSet& planes, const PlaneSlopes& slopes, const Lattice& lattice,
                                  int stride);

/// Pixels of planes where the function has the wrong sign.
struct BrokenPixels {
  std::vector<Vec3d> at;         ///< positions, world space
  std::vector<PlateDatum> data;  ///< the conditions that correct them
};

/// By node of a lattice, whether it is marked: one bit each.
using NodeMarks = std::vector<bool>;

/// The wrong pixels among every `stride`-th, of those next to nodes marked `on` and not too close to the
/// plane's contours.
BrokenPixels brokenPixels(const PlaneSet& planes, const Lattice& lattice, const std::vector<float>& values,
                          const NodeMarks& on, int stride);

}  // namespace slicemorph

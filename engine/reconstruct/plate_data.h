#pragma once

#include "engine/reconstruct/plane_set.h"
#include "engine/reconstruct/thin_plate.h"

namespace slicemorph {

/// Half width of the band of nodes around the surface that is solved on fine lattices, in nodes.
constexpr double kBandNodes = 5;

/// Whether a lattice is so small that all of it is solved.
bool isSolvedWhole(const Lattice& lattice);

/// How much of the surface's steepness lies in the plane, 0 to 1, by plane and edge.
using PlaneSlopes = std::vector<std::vector<float>>;

/// What the planes say about the function on a lattice: 0 on the contours, near them the distances in the planes (of
/// every `stride`-th pixel), outside beyond the planes where the object ends.
std::vector<PlateDatum> plateData(const PlaneSet& planes, const PlaneSlopes& slopes, const Lattice& lattice,
                                  int stride);

/// Pixels of planes where the function has the wrong sign.
struct BrokenPixels {
  std::vector<Vec3d> at;         ///< world
  std::vector<PlateDatum> data;  ///< what sets each right
};

/// Of every `stride`-th pixel, those next to nodes that are `on` and off the plane's contours.
BrokenPixels brokenPixels(const PlaneSet& planes, const Lattice& lattice, const std::vector<float>& values,
                          const std::vector<char>& on, int stride);

}  // namespace slicemorph

#pragma once

#include "engine/render/film.h"

/// Pictures of level sets: OpenVDB's ray tracer finds the surface; the shading (clay under a soft three-point
/// light) is chosen to make tears, bumps and floating pieces visible.
namespace slicemorph {

/// The world box of a level set's surface, up to a voxel larger. Throws GeometryError for an empty grid.
openvdb::BBoxd surfaceBox(const FloatGrid& levelSet);

/// A picture of a level set (class GRID_LEVEL_SET, any uniform scale and translation); an empty one gives the
/// background. `colors`: of the surface, on voxels around it; null: clay. Depth and normal are those of the
/// ray closest to the pixel's centre that hits the surface. Throws InputError for options out of range, for
/// grids with other transforms or classes, and for a perspective camera inside the surface.
Picture renderSurface(const FloatGrid& levelSet, const Camera& camera, const RenderOptions& options = {},
                      const openvdb::Vec3SGrid* colors = nullptr);

}  // namespace slicemorph

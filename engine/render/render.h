#pragma once

#include "engine/render/film.h"

/// Pictures of level sets: OpenVDB's ray tracer finds the surface, the shading is ours (clay under a soft
/// three-point light), chosen so that tears, bumps and floaters show.
namespace slicemorph {

/// The world box of a level set's surface (up to a voxel wider). Throws GeometryError for an empty grid.
openvdb::BBoxd surfaceBox(const FloatGrid& levelSet);

/// The picture of a level set (any uniform scale and translation of the grid, GRID_LEVEL_SET); an empty one
/// gives the background. `colors`: of the surface, on voxels around it; null: clay. Depth and normal are
/// those of the ray nearest to the pixel's middle that meets the surface. Throws InputError for options out
/// of range, for grids with other transforms or classes, and for a perspective camera inside the surface.
Picture renderSurface(const FloatGrid& levelSet, const Camera& camera, const RenderOptions& options = {},
                      const openvdb::Vec3SGrid* colors = nullptr);

}  // namespace slicemorph

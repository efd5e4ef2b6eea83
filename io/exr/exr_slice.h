#pragma once

#include "slicemorph/conventions.h"

#include <string>
#include <vector>

/// The layout of slices in EXR files, shared by the writer and the reader.
///
/// Channels    `NAME.Y` of numbers and flags, `NAME.X NAME.Y NAME.Z` of vectors, `NAME.sdf` of level sets
///             (world units, negative inside); with level sets one `coverage`, the share of the pixel inside
///             any of them.
/// Position    `sliceOrigin` (v3d, world: centre of pixel (0, 0)), `sliceAxisX`, `sliceAxisY` (downwards),
///             `sliceNormal` (v3d), `slicePixelSize` (double, world units), `sliceIndex`, `sliceCount` (int),
///             `sliceU` (double), `pixelToWorld` (m44d: row vector (i, j, 0, 1) times it = world),
///             `sliceUnits` ("mm", "world units"), and the standard `worldToCamera` (m44f: x right, y up, z
///             along the normal, from the image's centre) and `worldToNDC` (m44f: -1 to 1 across the display
///             window, y up).
/// Time        `sliceT` (double, 0 to 1), `sliceFrame` (int), `framesPerSecond`, where known.
/// Grids       `sliceGrids` (stringvector: their names), and of each `NAME.class`, `NAME.type` (the tree's),
///             `NAME.vectorType` (string), `NAME.halfFloat` (int), `NAME.background`, `NAME.voxelSize` (v3d,
///             world units), `NAME.transform` (m44d: row vector (i, j, k, 1) times it = world).
/// Windows     The display window is as large as the largest slice of the set; the data window is the slice.
namespace slicemorph {

/// A grid and its name in the channels: `density`, `density[1]` for the second grid of that name.
struct SliceGrid {
  std::string name;
  openvdb::GridBase::ConstPtr grid;
};

/// Whether a grid's values are signed distances.
bool isDistance(const openvdb::GridBase& grid);

/// Names of a grid's channels, one per component.
std::vector<std::string> sliceChannels(const std::string& name, const openvdb::GridBase& grid);

}  // namespace slicemorph

#pragma once

#include "engine/render/picture.h"
#include "engine/slices/section.h"

#include <string>

namespace slicemorph {

struct SliceExrOptions {
  /// A level set's slice is written as the channel `surface.sdf` (world units, negative inside) and
  /// `coverage` (1 inside, 0 outside, smooth over one pixel across the surface); another grid's as
  /// `<gridName>` alone.
  bool levelSet = true;
  std::string gridName = "surface";
};

/// Writes a slice as a float EXR (ZIP). Attributes place it in the world: `sliceOrigin` (centre of the first
/// pixel), `sliceAxisX`, `sliceAxisY` (downwards), `sliceNormal`, `slicePixelSize`, `sliceIndex`,
/// `sliceCount`, `sliceU`, `pixelToWorld` (row vector (i, j, 0, 1) times it = world) and the standard
/// `worldToCamera` (x right, y up, z along the normal, from the image's centre). The file appears whole or
/// not at all. Throws IoError.
void writeSliceExr(const std::string& path, const Section& section, const SliceExrOptions& options = {});

/// Writes a picture as a float EXR (ZIP), linear light: `R G B A`, premultiplied, and of its further channels
/// those that it has: `mask`, `Z` (depth along the axis of view, world units; 1e10 where there is nothing)
/// and `N.X N.Y N.Z` (world normal, 0 where there is nothing). The file appears whole or not at all. Throws
/// IoError.
void writePictureExr(const std::string& path, const Picture& image);

}  // namespace slicemorph

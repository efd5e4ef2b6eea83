#pragma once

#include "engine/follow/moving_mesh.h"

#include <string>

namespace slicemorph {

/// How world space maps to glTF's (metres, Y up). Points are written unchanged; a root node holds the map.
struct GlbSpace {
  double metres = 1;  ///< a world unit
  bool zUp = false;   ///< the world's Z points up, not its Y
};

/// Writes meshes as binary glTF 2.0 with vertex normals. A mesh of one frame is static; one of several frames
/// has a morph target for each frame but its first, and an animation of the targets' weights. Where there are
/// several meshes, each is visible only in its own frames (its node's scale is 0 in the others).
/// Colours of points are written as COLOR_0, clamped to 0 to 1, on a white material; colours that change have
/// morph targets too.
/// `numbers`: of the frames, ascending, by which they are named and timed; empty: 1, 2, 3 ... Frame i is
/// at (numbers[i] - numbers[0]) / framesPerSecond seconds. A frame whose mesh has no triangles shows nothing. The file appears whole or not at all. Throws IoError, also where the data exceeds the
/// format's 4 GiB.
void writeGlb(const std::string& path, const std::vector<MovingMesh>& meshes, double framesPerSecond = 24,
              const GlbSpace& space = {}, const std::vector<int>& numbers = {});

/// The bytes that writeGlb writes. Throws IoError.
std::string encodeGlb(const std::vector<MovingMesh>& meshes, double framesPerSecond = 24,
                      const GlbSpace& space = {});

}  // namespace slicemorph

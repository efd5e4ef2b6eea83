#pragma once

#include "engine/follow/moving_mesh.h"

#include <string>

namespace slicemorph {

/// How glTF's space (metres, Y up) is told what the world's is; points are written as they are, a node above
/// them holds this.
struct GlbSpace {
  double metres = 1;  ///< a world unit
  bool zUp = false;   ///< the world's Z points up, not its Y
};

/// Writes meshes as binary glTF 2.0 with vertex normals. Those of one frame are still; over several frames a
/// mesh has a morph target for each frame but its first, and an animation of their weights. Where there are
/// several meshes, each is there only in its own frames (its node's scale is 0 in the others).
/// Colours of points are written as COLOR_0, within 0 to 1, on a white material; those that change have morph
/// targets too.
/// `framesPerSecond`: frame i, from 0, is at i / framesPerSecond seconds; one whose mesh has no triangles
/// shows nothing. Whole or not at all; throws IoError, also for what does not fit the 4 GiB of the format.
void writeGlb(const std::string& path, const std::vector<MovingMesh>& meshes, double framesPerSecond = 24,
              const GlbSpace& space = {});

/// The bytes of such a file. Throws IoError.
std::string encodeGlb(const std::vector<MovingMesh>& meshes, double framesPerSecond = 24,
                      const GlbSpace& space = {});

}  // namespace slicemorph

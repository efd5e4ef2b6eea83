#pragma once

#include "engine/conventions.h"

/// Pictures of level sets: OpenVDB's ray tracer finds the surface, the shading is ours (clay under a soft
/// three-point light), chosen so that tears, bumps and floaters show.
namespace slicemorph {

/// Linear light, red green blue alpha interleaved, first row on top; alpha is 1 where the background is
/// drawn.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;  ///< 4 * width * height
};

/// Looks from `position` at `target`, all in world units.
struct Camera {
  Vec3d position{0, 0, 1};
  Vec3d target{0, 0, 0};
  Vec3d up{0, 1, 0};              ///< need not be orthogonal to the direction of view, only not along it
  double verticalFov = 25;        ///< degrees, perspective
  double orthographicHeight = 0;  ///< world units seen from bottom to top; above 0 the camera is orthographic
};

struct FrameAllOptions {
  Vec3d direction{-0.55, -0.3, -1};  ///< from the camera into the scene, world; any length
  Vec3d up{0, 1, 0};
  double aspect = 4.0 / 3.0;  ///< width over height of the pictures
  double margin = 0.03;       ///< free share of the picture on each side
  double verticalFov = 25;    ///< degrees; 0 makes the camera orthographic
};

/// The world box of a level set's surface (up to a voxel wider). Throws GeometryError for an empty grid.
openvdb::BBoxd surfaceBox(const FloatGrid& levelSet);

/// A camera that sees the whole of every box: given the boxes of all frames, one camera serves the sequence.
/// Throws InputError for no or an empty box, a zero direction, or one along `up`.
Camera frameAll(const std::vector<openvdb::BBoxd>& boxes, const FrameAllOptions& options = {});

enum class Shading { kClay, kNormals };

struct RenderOptions {
  int width = 640;                   ///< pixels, 1 to 16384
  int height = 480;                  ///< pixels, 1 to 16384
  int samples = 4;                   ///< rays per pixel where something is to be seen, 1 to 64
  Shading shading = Shading::kClay;  ///< kNormals: red, green and blue are the world normal, for debugging
  bool background = true;            ///< false: transparent (alpha 0, colour premultiplied)
};

/// The picture of a level set (any uniform scale and translation of the grid, GRID_LEVEL_SET); an empty one
/// gives the background. Throws InputError for options out of range and for grids with other transforms or
/// classes.
Picture renderSurface(const FloatGrid& levelSet, const Camera& camera, const RenderOptions& options = {});

}  // namespace slicemorph

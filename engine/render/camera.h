#pragma once

#include "engine/render/picture.h"
#include "slicemorph/conventions.h"

#include <openvdb/math/Ray.h>

#include <vector>

/// Cameras.
namespace slicemorph {

/// Looks from `position` at `target`; world space.
struct Camera {
  Vec3d position{0, 0, 1};
  Vec3d target{0, 0, 0};
  Vec3d up{0, 1, 0};              ///< need not be orthogonal to the viewing direction, but not parallel to it
  double verticalFov = 25;        ///< degrees, perspective
  double orthographicHeight = 0;  ///< height of the view in world units; above 0 the camera is orthographic
};

struct FrameAllOptions {
  Vec3d direction{-0.55, -0.3, -1};  ///< viewing direction from the camera into the scene, world; any length
  Vec3d up{0, 1, 0};
  double aspect = 4.0 / 3.0;  ///< width over height of the pictures
  double margin = 0.03;       ///< part of the picture that stays free on each side
  double verticalFov = 25;    ///< degrees; 0 makes the camera orthographic
  bool allRound = false;      ///< keep the boxes in view from all positions that turned() can produce
};

/// A camera that sees all of every box; given the boxes of all frames, one camera serves the whole
/// sequence. Throws InputError for no or an empty box, a zero direction, one parallel to `up`, and other
/// options out of range.
Camera frameAll(const std::vector<openvdb::BBoxd>& boxes, const FrameAllOptions& options = {});

/// The camera rotated about its target by an angle (radians) around `up`, counter-clockwise as
/// seen from above.
Camera turned(const Camera& camera, double angle);

/// A right-handed orthonormal basis: right, up and back (towards the viewer).
struct ViewBasis {
  Vec3d right, up, back;
  Vec3d toWorld(const Vec3d& v) const { return right * v.x() + up * v.y() + back * v.z(); }
};

/// Throws InputError if the camera's target is its position, or in the direction of `up` from it.
ViewBasis basisOf(const Camera& camera);

/// The matrices of a picture. `aspect`: width over height. Throws as basisOf.
ViewMatrices viewMatrices(const Camera& camera, double aspect);

using ViewRay = openvdb::math::Ray<double>;

/// Rays through positions in the picture.
class CameraRays {
 public:
  /// `aspect`: width over height. `box`: world box of everything visible; rays of an orthographic camera
  /// start in front of it. Throws as basisOf.
  CameraRays(const Camera& camera, double aspect, const openvdb::BBoxd& box);

  /// `x`, `y`: position in the picture, -1 to 1, to the right and up.
  ViewRay operator()(double x, double y) const;
  /// Depth of a world point: distance from the plane through the camera's position, perpendicular to its
  /// viewing direction; world units.
  double depth(const Vec3d& world) const { return (position_ - world).dot(basis_.back); }
  const ViewBasis& basis() const { return basis_; }

 private:
  ViewBasis basis_;
  Vec3d position_, eye_, across_, upwards_;
  bool orthographic_ = false;
};

/// Position of the n-th ray within a pixel's unit square, the first in its centre: the R2 sequence, evenly
/// spread for any number of rays [Rob18].
openvdb::Vec2d samplePosition(int n);

}  // namespace slicemorph

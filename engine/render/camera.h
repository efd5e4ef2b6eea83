#pragma once

#include "slicemorph/conventions.h"

#include <openvdb/math/Ray.h>

#include <vector>

/// Where pictures are taken from.
namespace slicemorph {

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
  bool allRound = false;      ///< the boxes are seen whole from every place that turned() leads to
};

/// A camera that sees the whole of every box: given the boxes of all frames, one camera serves the sequence.
/// Throws InputError for no or an empty box, a zero direction, or one along `up`.
Camera frameAll(const std::vector<openvdb::BBoxd>& boxes, const FrameAllOptions& options = {});

/// The camera led round its target by an angle (radians), about `up`, counter-clockwise as seen from above.
Camera turned(const Camera& camera, double angle);

/// Right, up and backwards (towards the viewer): a right-handed orthonormal set.
struct ViewBasis {
  Vec3d right, up, back;
  Vec3d toWorld(const Vec3d& v) const { return right * v.x() + up * v.y() + back * v.z(); }
};

/// Throws InputError where the camera's target is its position or straight along `up` from it.
ViewBasis basisOf(const Camera& camera);

using ViewRay = openvdb::math::Ray<double>;

/// Turns places of a picture into rays.
class CameraRays {
 public:
  /// `aspect`: width over height. `box`: world, of all that is to be seen; rays of an orthographic camera
  /// start before it. Throws as basisOf.
  CameraRays(const Camera& camera, double aspect, const openvdb::BBoxd& box);

  /// `x`, `y` in -1..1, to the right and up.
  ViewRay operator()(double x, double y) const;
  /// Of a world point, from the plane through the camera's position across its axis of view; world units.
  double depth(const Vec3d& world) const { return (position_ - world).dot(basis_.back); }
  const ViewBasis& basis() const { return basis_; }

 private:
  ViewBasis basis_;
  Vec3d position_, eye_, across_, upwards_;
  bool orthographic_ = false;
};

/// Places of the rays in a pixel's unit square, the first in its middle: the R2 sequence, even at any length
/// [Rob18].
openvdb::Vec2d samplePosition(int n);

}  // namespace slicemorph

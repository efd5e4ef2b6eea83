#include "engine/render/camera.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;

ViewBasis basisOf(const Vec3d& direction, const Vec3d& up) {
  const Vec3d side = direction.cross(up);
  if (!(side.length() > 1e-6 * direction.length() * up.length()))
    throw InputError("camera: the direction of view must not be zero or along `up`");
  ViewBasis basis;
  basis.back = -direction.unit();
  basis.right = side.unit();
  basis.up = basis.back.cross(basis.right);
  return basis;
}

/// Half the height of the view: in world units of an orthographic camera, else at distance 1.
double halfHeight(const Camera& camera) {
  if (camera.orthographicHeight > 0) return camera.orthographicHeight / 2;
  return std::tan(camera.verticalFov * kPi / 360);
}

/// Rodrigues' formula; the axis must be a unit vector.
Vec3d rotate(const Vec3d& v, const Vec3d& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1 - c));
}

std::vector<Vec3d> cornersOf(const std::vector<openvdb::BBoxd>& boxes) {
  std::vector<Vec3d> corners;
  for (const auto& box : boxes) {
    if (box.empty()) throw InputError("camera: a box to be seen is empty");
    for (int n = 0; n < 8; ++n) {
      corners.emplace_back((n & 1 ? box.max() : box.min()).x(), (n & 2 ? box.max() : box.min()).y(),
                           (n & 4 ? box.max() : box.min()).z());
    }
  }
  if (corners.empty()) throw InputError("camera: no box to be seen");
  return corners;
}

/// Centre of the points' bounding box along the axes of the basis.
Vec3d middleAlong(const std::vector<Vec3d>& points, const ViewBasis& basis) {
  Vec3d lo(std::numeric_limits<double>::max()), hi(-std::numeric_limits<double>::max());
  for (const Vec3d& p : points) {
    const Vec3d local(p.dot(basis.right), p.dot(basis.up), p.dot(basis.back));
    lo = openvdb::math::minComponent(lo, local);
    hi = openvdb::math::maxComponent(hi, local);
  }
  return basis.toWorld((lo + hi) / 2);
}

/// Positions of points that turn about an axis through `centre`, every 5 degrees. Between two of them, 2.5
/// degrees away, points reach 0.1 % farther (1 / cos 2.5 degrees), which the margin covers.
std::vector<Vec3d> turnedRound(const std::vector<Vec3d>& points, const Vec3d& centre, const Vec3d& axis) {
  constexpr int kSteps = 72;
  std::vector<Vec3d> all;
  for (int n = 0; n < kSteps; ++n)
    for (const Vec3d& p : points) all.push_back(centre + rotate(p - centre, axis, 2 * kPi * n / kSteps));
  return all;
}

}  // namespace

ViewBasis basisOf(const Camera& camera) { return basisOf(camera.target - camera.position, camera.up); }

Camera frameAll(const std::vector<openvdb::BBoxd>& boxes, const FrameAllOptions& options) {
  std::vector<Vec3d> points = cornersOf(boxes);
  const ViewBasis basis = basisOf(options.direction, options.up);
  if (!(options.aspect > 0) || !(options.margin >= 0 && options.margin < 0.5)) {
    throw InputError("camera: the aspect must be above 0 and the margin 0 to 0.5");
  }
  Camera camera;
  camera.up = options.up;
  camera.target = middleAlong(points, basis);
  if (options.allRound) points = turnedRound(points, camera.target, options.up.unit());

  const double share = 1 - 2 * options.margin;
  double radius = std::numeric_limits<double>::min(), height = 0;
  for (const Vec3d& point : points) {
    const Vec3d p = point - camera.target;
    radius = std::max(radius, p.length());
    height = std::max({height, std::abs(p.dot(basis.up)), std::abs(p.dot(basis.right)) / options.aspect});
  }
  if (!(options.verticalFov > 0)) {
    camera.orthographicHeight = 2 * height / share;
    camera.position = camera.target + basis.back * (2 * radius);
    return camera;
  }
  camera.verticalFov = options.verticalFov;
  const double tanUp = std::tan(options.verticalFov * kPi / 360) * share, tanAcross = tanUp * options.aspect;
  double distance = 0;
  for (const Vec3d& point : points) {
    const Vec3d p = point - camera.target;
    const double fit = std::max(std::abs(p.dot(basis.right)) / tanAcross, std::abs(p.dot(basis.up)) / tanUp);
    distance = std::max(distance, fit + p.dot(basis.back));
  }
  camera.position = camera.target + basis.back * std::max(distance, 1e-6 * radius);
  return camera;
}

Camera turned(const Camera& camera, double angle) {
  Camera result = camera;
  result.position = camera.target + rotate(camera.position - camera.target, camera.up.unit(), angle);
  return result;
}

ViewMatrices viewMatrices(const Camera& camera, double aspect) {
  const ViewBasis basis = slicemorph::basisOf(camera);
  ViewMatrices view;
  view.worldToCamera.setIdentity();
  const Vec3d axes[3] = {basis.right, basis.up, -basis.back};
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) view.worldToCamera(row, column) = axes[column][row];
    view.worldToCamera(3, column) = -camera.position.dot(axes[column]);
  }
  openvdb::Mat4d screen = openvdb::Mat4d::identity();
  const bool orthographic = camera.orthographicHeight > 0;
  const double half = halfHeight(camera);
  screen(0, 0) = 1 / (half * aspect), screen(1, 1) = 1 / half;
  if (!orthographic) {
    // Depth is 0 on a near plane, which is there only so that the matrix has an inverse, and 1 far away.
    const double nearest = 1e-3 * (camera.target - camera.position).length();
    screen(2, 3) = 1, screen(3, 2) = -nearest, screen(3, 3) = 0;
  }
  view.worldToScreen = view.worldToCamera * screen;
  return view;
}

CameraRays::CameraRays(const Camera& camera, double aspect, const openvdb::BBoxd& box)
    : basis_(slicemorph::basisOf(camera)), position_(camera.position), eye_(camera.position) {
  orthographic_ = camera.orthographicHeight > 0;
  const double half = halfHeight(camera);
  across_ = basis_.right * (half * aspect);
  upwards_ = basis_.up * half;
  // An orthographic camera has no near side: rays start in front of everything.
  if (orthographic_ && !box.empty())
    eye_ += basis_.back * (box.extents().length() + (box.getCenter() - camera.position).length());
}

ViewRay CameraRays::operator()(double x, double y) const {
  const Vec3d offset = across_ * x + upwards_ * y;
  if (orthographic_) return ViewRay(eye_ + offset, -basis_.back);
  return ViewRay(eye_, (offset - basis_.back).unit());
}

openvdb::Vec2d samplePosition(int n) {
  // 1 / p and 1 / p^2 for the plastic number p, the real root of x^3 = x + 1 [Rob18].
  const double x = 0.5 + 0.7548776662466927 * n, y = 0.5 + 0.5698402909980532 * n;
  return {x - std::floor(x), y - std::floor(y)};
}

}  // namespace slicemorph

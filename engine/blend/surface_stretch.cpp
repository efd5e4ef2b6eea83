#include "engine/blend/surface_stretch.h"

#include "engine/numerics/nearest_rotation.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

constexpr size_t kStretchSamples = 1500;
/// Half the distance over which the map is differentiated, in the object's diagonals: some half a cell of the lattice.
constexpr double kStep = 0.005;

Vec3d anyTangent(const Vec3d& normal) {
  return normal.cross(std::abs(normal[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).unit();
}

/// The derivative of a map at a surface sample, along the surface.
struct Slope {
  double longer, shorter;  ///< principal stretches
  Mat3d outer;             ///< sum of outer products, whose nearest rotation is how the surface is turned
};

/// `before`: two unit tangents at right angles; `after`: the derivatives along them.
Slope slopeOf(const Vec3d (&before)[2], const Vec3d (&after)[2]) {
  Slope slope{1, 1, Mat3d::zero()};
  // Squares of the principal stretches: the eigenvalues of the derivatives' products.
  const double a = after[0].lengthSqr(), b = after[0].dot(after[1]), c = after[1].lengthSqr();
  const double middle = 0.5 * (a + c), apart = std::hypot(0.5 * (a - c), b);
  slope.longer = std::sqrt(middle + apart), slope.shorter = std::sqrt(std::max(middle - apart, 1e-12));
  addOuter(slope.outer, 1, after[0], before[0]), addOuter(slope.outer, 1, after[1], before[1]);
  const Vec3d normal = after[0].cross(after[1]);
  if (normal.length() > 0)
    addOuter(slope.outer, 1, normal / std::sqrt(normal.length()), before[0].cross(before[1]));
  return slope;
}

}  // namespace

SurfaceStretch surfaceStretch(const MovingLattice& lattice, const DistanceField& field, size_t object,
                              const LatticePose& pose) {
  const std::vector<SurfaceSample>& all = field.samples();
  const size_t stride = std::max<size_t>(all.size() / kStretchSamples, 1);
  const double h = kStep * field.box().extents().length();
  std::vector<Vec3d> points, tangents;
  std::vector<double> area;
  for (size_t i = 0; i < all.size(); i += stride) {
    const Vec3d u = anyTangent(all[i].normal), v = all[i].normal.cross(u);
    for (const Vec3d& t : {u, v}) {
      tangents.push_back(t);
      points.push_back(all[i].position + h * t), points.push_back(all[i].position - h * t);
    }
    area.push_back(all[i].area);
  }
  const std::vector<Vec3d> at = lattice.carryPoints(points, lattice.poseOf(object), pose);
  std::vector<Slope> slopes;
  double size = 0, total = 0;
  Mat3d outer = Mat3d::zero();
  for (size_t i = 0; i < area.size(); ++i) {
    const Vec3d before[2] = {tangents[2 * i], tangents[2 * i + 1]};
    const Vec3d after[2] = {(at[4 * i] - at[4 * i + 1]) / (2 * h), (at[4 * i + 2] - at[4 * i + 3]) / (2 * h)};
    slopes.push_back(slopeOf(before, after));
    size += area[i] * 0.5 * std::log(slopes[i].longer * slopes[i].shorter), total += area[i];
    outer += area[i] * slopes[i].outer;
  }
  SurfaceStretch result;
  if (!(total > 0)) return result;
  size = std::exp(size / total), result.mean = 0;
  const Mat3d whole = nearestRotation(outer);
  for (size_t i = 0; i < area.size(); ++i) {
    const double stretch = std::max(slopes[i].longer / size, size / slopes[i].shorter),
                 share = area[i] / total;
    result.mean += share * stretch, result.worst = std::max(result.worst, stretch);
    if (stretch > SurfaceStretch::kMuch) result.beyond += share;
    result.turned += share * rotationVector(whole.transpose() * nearestRotation(slopes[i].outer)).length();
  }
  return result;
}

}  // namespace slicemorph

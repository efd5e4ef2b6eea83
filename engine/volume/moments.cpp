#include "engine/volume/moments.h"

#include "slicemorph/errors.h"

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace slicemorph {

namespace {

/// Calls visit(position, share inside) for every coarse node whose cell is at least partly inside.
template <typename Visit>
void visitInside(const DistanceField& field, const Visit& visit) {
  const auto& n = field.size();
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        const double share = 0.5 - field.nodeDistance(x, y, z) / field.spacing();
        if (share > 0) visit(field.nodePosition(x, y, z), std::min(share, 1.0));
      }
}

}  // namespace

Moments insideMoments(const DistanceField& field) {
  double total = 0;
  Vec3d sum(0.0);
  visitInside(field, [&](const Vec3d& p, double share) { total += share, sum += share * p; });
  if (!(total > 0)) throw GeometryError("the level set '" + field.levelSet().getName() + "' has no inside");
  Moments m;
  m.centroid = sum / total;
  m.volume = total * field.spacing() * field.spacing() * field.spacing();
  visitInside(field, [&](const Vec3d& p, double share) {
    const Vec3d d = p - m.centroid;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m.covariance(i, j) += share * d[i] * d[j];
  });
  m.covariance *= 1.0 / total;
  return m;
}

PrincipalAxes principalAxes(const Mat3d& covariance) {
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = 0.5 * (covariance(i, j) + covariance(j, i));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(c);
  PrincipalAxes result;
  for (int a = 0; a < 3; ++a) {
    result.variances[a] = solver.eigenvalues()[2 - a];
    for (int i = 0; i < 3; ++i) result.axes(i, a) = solver.eigenvectors()(i, 2 - a);
  }
  if (result.axes.det() < 0)
    for (int i = 0; i < 3; ++i) result.axes(i, 2) = -result.axes(i, 2);
  return result;
}

}  // namespace slicemorph

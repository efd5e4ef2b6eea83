#include "engine/numerics/nearest_rotation.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace slicemorph {

Mat3d nearestRotation(const Mat3d& s) {
  Eigen::Matrix3d matrix;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) matrix(r, c) = s(r, c);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  const Eigen::Matrix3d nearest = u * svd.matrixV().transpose();
  Mat3d rotation;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rotation(r, c) = nearest(r, c);
  return rotation;
}

}  // namespace slicemorph

#include "engine/frame/feature_turns.h"

#include "engine/numerics/nearest_rotation.h"
#include "engine/spine/chart.h"

#include <Eigen/Core>
#include <Eigen/SVD>

#include <cmath>

namespace slicemorph {

namespace {

/// Points whose spread across a line is less than this share of that along it lie on the line. Chosen by
/// hand; guarded by Features.PointsInALineTurnItToo.
constexpr double kInLine = 0.2;

/// The points moved to a centroid of 0 and scaled to a root mean square distance of 1 from it.
std::vector<Vec3d> normalised(const std::vector<Vec3d>& points) {
  Vec3d middle(0.0);
  for (const Vec3d& p : points) middle += p / double(points.size());
  double size = 0;
  for (const Vec3d& p : points) size += (p - middle).lengthSqr() / double(points.size());
  std::vector<Vec3d> result;
  result.reserve(points.size());
  for (const Vec3d& p : points) result.push_back(size > 0 ? (p - middle) / std::sqrt(size) : Vec3d(0.0));
  return result;
}

/// Sum of the outer products b a^T.
Mat3d productOf(const std::vector<Vec3d>& b, const std::vector<Vec3d>& a) {
  Mat3d sum = Mat3d::zero();
  for (size_t i = 0; i < a.size(); ++i) addOuter(sum, 1, b[i], a[i]);
  return sum;
}

}  // namespace

std::vector<Vec3d> pointsOn(const std::vector<Feature>& features, size_t object) {
  std::vector<Vec3d> points;
  for (const Feature& feature : features) {
    const std::vector<Vec3d>& own = feature.positions[object];
    // A line may have different numbers of points on each object; only its ends correspond.
    points.push_back(own.front());
    if (feature.kind == Feature::Kind::kLine) points.push_back(own.back());
    if (feature.kind == Feature::Kind::kDisk)
      points.push_back(own.front() + feature.radii[object] * feature.normals[object].unit());
  }
  return points;
}

Mat3d rotationOnto(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to) {
  return nearestRotation(productOf(to, from));
}

double misfit(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to, const Mat3d& rotation) {
  if (from.size() < 2) return 0;
  const std::vector<Vec3d> a = normalised(from), b = normalised(to);
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (rotation * a[i] - b[i]).lengthSqr() / double(a.size());
  return std::sqrt(sum);
}

std::vector<Mat3d> turnsOf(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to) {
  if (from.size() < 2) return {};
  const std::vector<Vec3d> a = normalised(from), b = normalised(to);
  const Mat3d product = productOf(b, a);
  using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::Matrix3d matrix = Eigen::Map<const Rows>(product.asPointer());
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& spread = svd.singularValues();
  if (!(spread[0] > 0)) return {};
  const Mat3d best = rotationOnto(a, b);
  if (spread[1] > kInLine * kInLine * spread[0]) return {best};  // singular values are squared lengths
  const Vec3d line(svd.matrixU()(0, 0), svd.matrixU()(1, 0), svd.matrixU()(2, 0));
  // The rotation of least angle that takes one line to the other comes first.
  const Vec3d start(svd.matrixV()(0, 0), svd.matrixV()(1, 0), svd.matrixV()(2, 0));
  const Vec3d axis = start.cross(line);
  const double sine = axis.length(), cosine = start.dot(line);
  Vec3d side = std::abs(line[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
  side = line.cross(side).unit();
  const Mat3d least = rotationFromVector((sine > 1e-9 ? axis / sine : side) * std::atan2(sine, cosine));
  std::vector<Mat3d> turns;
  turns.reserve(4);
  for (int quarter = 0; quarter < 4; ++quarter)
    turns.push_back(rotationFromVector(line * (quarter * M_PI / 2)) * least);
  return turns;
}

}  // namespace slicemorph

#pragma once

#include "slicemorph/mesh.h"

#include <Eigen/Core>
#include <unsupported/Eigen/MatrixFunctions>

/// Bars that bend and twist, by the closed form of a rigid motion of constant rate.
namespace slicemorph::shapes {

/// A spine of unit speed whose coordinate frame turns, on each piece, at a constant rate (about the tangent,
/// y and z of the frame; radians per unit). At s = 0 it passes the origin along x.
class Curl {
 public:
  struct Piece {
    double from, to;
    Vec3d rate;
  };
  explicit Curl(const Vec3d& rate) : pieces_{{-1e9, 1e9, rate}} {}
  explicit Curl(std::vector<Piece> pieces) : pieces_(std::move(pieces)) {}

  /// Rates interpolated linearly to another's at `t`; one of the two must have one piece only.
  Curl mixed(const Curl& to, double t) const {
    Curl result = pieces_.size() > 1 ? *this : to;
    for (size_t i = 0; i < result.pieces_.size(); ++i)
      result.pieces_[i].rate = (1 - t) * pieces_[std::min(i, pieces_.size() - 1)].rate +
                               t * to.pieces_[std::min(i, to.pieces_.size() - 1)].rate;
    return result;
  }

  /// Where a point of the straight shape (spine along x) lies on the bent one.
  Vec3d apply(const Vec3d& p) const {
    const Eigen::Matrix4d m = at(p[0]);
    const Eigen::Vector4d w = m * Eigen::Vector4d(0, p[1], p[2], 1);
    return {w[0], w[1], w[2]};
  }

 private:
  /// Rigid motion of the coordinate frame from s = 0 to s.
  Eigen::Matrix4d at(double s) const {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    const double sign = s < 0 ? -1 : 1;
    std::vector<Piece> ordered = pieces_;
    if (s < 0) std::reverse(ordered.begin(), ordered.end());
    for (const Piece& p : ordered) {
      const double a = s < 0 ? std::min(p.to, 0.0) : std::max(p.from, 0.0);
      const double b = s < 0 ? std::max(p.from, s) : std::min(p.to, s);
      if (sign * (b - a) <= 0) continue;
      Eigen::Matrix4d g = Eigen::Matrix4d::Zero();
      g(0, 1) = -p.rate[2], g(0, 2) = p.rate[1], g(1, 0) = p.rate[2], g(1, 2) = -p.rate[0];
      g(2, 0) = -p.rate[1], g(2, 1) = p.rate[0], g(0, 3) = 1;
      const Eigen::Matrix4d step = (g * (b - a)).exp();
      m = m * step;
    }
    return m;
  }
  std::vector<Piece> pieces_;
};

/// The mesh of a shape along x, bent.
inline Mesh bent(const Mesh& straight, const Curl& curl) {
  Mesh mesh = straight;
  for (auto& p : mesh.points) p = openvdb::Vec3s(curl.apply(Vec3d(p)));
  return mesh;
}

}  // namespace slicemorph::shapes

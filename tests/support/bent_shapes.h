#pragma once

#include "slicemorph/mesh.h"

#include <Eigen/Core>
#include <unsupported/Eigen/MatrixFunctions>

/// Bars that bend and twist, by the closed form of a rigid motion of constant rate.
namespace slicemorph::shapes {

/// A spine of unit speed whose frame turns at a constant rate (about itself, about y, about z; radians per
/// unit) on each of some pieces; s = 0 lies at the origin, along x.
class Curl {
 public:
  struct Piece {
    double from, to;
    Vec3d rate;
  };
  explicit Curl(const Vec3d& rate) : pieces_{{-1e9, 1e9, rate}} {}
  explicit Curl(std::vector<Piece> pieces) : pieces_(std::move(pieces)) {}

  /// Rates a share `t` of the way to another's; one of the two must be of one piece.
  Curl mixed(const Curl& to, double t) const {
    Curl result = pieces_.size() > 1 ? *this : to;
    for (size_t i = 0; i < result.pieces_.size(); ++i)
      result.pieces_[i].rate = (1 - t) * pieces_[std::min(i, pieces_.size() - 1)].rate +
                               t * to.pieces_[std::min(i, to.pieces_.size() - 1)].rate;
    return result;
  }

  Vec3d place(const Vec3d& p) const {
    const Eigen::Matrix4d m = at(p[0]);
    const Eigen::Vector4d w = m * Eigen::Vector4d(0, p[1], p[2], 1);
    return {w[0], w[1], w[2]};
  }

 private:
  /// The frame's motion from s = 0 to s.
  Eigen::Matrix4d at(double s) const {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    const double sign = s < 0 ? -1 : 1;
    std::vector<Piece> way = pieces_;
    if (s < 0) std::reverse(way.begin(), way.end());
    for (const Piece& p : way) {
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
  for (auto& p : mesh.points) p = openvdb::Vec3s(curl.place(Vec3d(p)));
  return mesh;
}

}  // namespace slicemorph::shapes

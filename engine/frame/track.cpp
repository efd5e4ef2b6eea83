#include "engine/frame/track.h"

#include "engine/volume/moments.h"

#include <tbb/parallel_for.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// The figures are chosen by hand; the tests `Track` and `Sequence` in tests/engine/sequence_test.cpp guard
// what they are for. Lengths are in sizes of the object (cube root of its volume).

/// Scale of the robust weight: at first, in the end, and its factor from step to step.
constexpr double kFirstReach = 0.3, kLastReach = 0.03, kReachStep = 0.7;
constexpr int kMostSteps = 40;
/// The iteration ends with a step smaller than this (radians and sizes).
constexpr double kSmallStep = 1e-5;
/// An axis about which a turn changes the mean squared residual by less than this per radian squared is one
/// of symmetry: the object is not turned about it.
constexpr double kRound = 5e-4;
/// Prior on the turn: the residuals are taken for the deformation of this many independent parts, and a turn
/// from frame to frame to be of this order (radians).
constexpr double kParts = 30, kUsualTurn = 0.2;

/// One sample's term of the least-squares problem: weight * (residual + row . step)^2.
struct Term {
  Vector6 row = Vector6::Zero();  ///< derivatives by the turn (3) and the move (3)
  double residual = 0, weight = 0;
};

/// Gauss-Newton iteration for one object's motion.
class Tracker {
 public:
  Tracker(const DistanceField& earlier, const DistanceField& now, Align align)
      : earlier_(earlier), now_(now), align_(align) {
    const Moments a = insideMoments(earlier), b = insideMoments(now);
    size_ = std::cbrt(b.volume);
    motion_.from = a.centroid, motion_.to = b.centroid;
    if (align != Align::kNone) motion_.scale = std::cbrt(b.volume / a.volume);
  }

  Motion run() {
    double reach = kFirstReach;
    for (int i = 0; i < kMostSteps; ++i, reach = std::max(kReachStep * reach, kLastReach)) {
      const Vector6 step = nextStep(reach);
      const Vec3d turn(step[0], step[1], step[2]), move(step[3], step[4], step[5]);
      motion_.rotation = rotationFromVector(turn) * motion_.rotation;
      motion_.to += size_ * move;
      if (reach == kLastReach && step.norm() < kSmallStep) break;
    }
    return motion_;
  }

 private:
  /// The term of a surface point `at`. `distance`, `normal`: of the other surface there; `facing`: cosine
  /// between the two normals.
  Term termOf(const Vec3d& at, double distance, const Vec3d& normal, double facing, double reach) const {
    Term term;
    const Vec3d turn = ((at - motion_.to) / size_).cross(normal);
    for (int a = 0; a < 3; ++a)
      term.row[a] = align_ == Align::kAuto ? turn[a] : 0, term.row[3 + a] = normal[a];
    term.residual = distance / size_;
    const double off = term.residual / reach, trust = 1 / (1 + off * off);
    term.weight = std::max(facing, 0.0) * trust * trust;
    return term;
  }

  std::vector<Term> terms(double reach) const {
    const std::vector<SurfaceSample>&a = earlier_.samples(), &b = now_.samples();
    std::vector<Term> result(a.size() + b.size());
    const double unit = size_ * size_;
    tbb::parallel_for(size_t(0), a.size(), [&](size_t i) {
      const Vec3d at = motion_(a[i].position), normal = now_.gradient(at);
      result[i] = termOf(at, now_.coarse(at), normal, normal.dot(motion_.rotation * a[i].normal), reach);
      result[i].weight *= motion_.scale * motion_.scale * a[i].area / unit;
    });
    const Mat3d back = motion_.rotation.transpose();
    tbb::parallel_for(size_t(0), b.size(), [&](size_t i) {
      const Vec3d& at = b[i].position;
      const Vec3d p = motion_.from + back * (at - motion_.to) / motion_.scale;
      const Vec3d normal = motion_.rotation * earlier_.gradient(p);
      Term& term = result[a.size() + i];
      term = termOf(at, -motion_.scale * earlier_.coarse(p), normal, normal.dot(b[i].normal), reach);
      term.weight *= b[i].area / unit;
    });
    return result;
  }

  Vector6 nextStep(double reach) const {
    Matrix6 h = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    double weight = 0, square = 0;
    for (const Term& s : terms(reach)) {
      h += s.weight * s.row * s.row.transpose();
      g += s.weight * s.residual * s.row;
      weight += s.weight, square += s.weight * s.residual * s.residual;
    }
    if (!(weight > 0)) return Vector6::Zero();
    h /= weight, g /= weight;
    h.diagonal().array() += 1e-9;
    const Eigen::Matrix3d prior = priorOf(h, square / weight);
    const Vec3d turned = rotationVector(motion_.rotation);
    h.topLeftCorner<3, 3>() += prior;
    g.head<3>() += prior * Eigen::Vector3d(turned[0], turned[1], turned[2]);
    return -h.ldlt().solve(g);
  }

  /// The prior on the turn as a quadratic form: weak where the fit is certain, so strong about axes of
  /// symmetry that the object does not turn about them.
  static Eigen::Matrix3d priorOf(const Matrix6& h, double variance) {
    const Eigen::Matrix3d cross = h.topRightCorner<3, 3>(), moves = h.bottomRightCorner<3, 3>();
    const Eigen::Matrix3d turns = h.topLeftCorner<3, 3>() - cross * moves.ldlt().solve(cross.transpose());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(turns);
    Eigen::Vector3d prior;
    for (int a = 0; a < 3; ++a)
      prior[a] = kRound * kRound / std::max(solver.eigenvalues()[a], 1e-9) +
                 variance / (kParts * kUsualTurn * kUsualTurn);
    return solver.eigenvectors() * prior.asDiagonal() * solver.eigenvectors().transpose();
  }

  const DistanceField &earlier_, &now_;
  Align align_;
  double size_ = 1;
  Motion motion_;
};

}  // namespace

Motion trackMotion(const DistanceField& earlier, const DistanceField& now, Align align) {
  return Tracker(earlier, now, align).run();
}

Frames trackFrames(const Frames& frames, const Fields& earlier, const Fields& now,
                   const std::vector<std::string>& names, Align align) {
  Frames result = frames;
  result.notes.clear();
  for (size_t k = 0; k < now.size(); ++k) {
    if (earlier[k] == now[k]) continue;
    const Motion motion = trackMotion(*earlier[k], *now[k], align);
    Chart& chart = result.charts[k];
    chart.center = motion(chart.center);
    chart.axes = motion.rotation * chart.axes;
    chart.scale *= motion.scale;
    char text[160];
    std::snprintf(text, sizeof text,
                  "moved by %.4g, turned by %.1f degrees and grew %.3f times since the frame before",
                  (motion.to - motion.from).length(), rotationVector(motion.rotation).length() * 180 / M_PI,
                  motion.scale);
    result.notes.push_back({"sequence.moved", Severity::kDetail, names[k], text});
  }
  return result;
}

}  // namespace slicemorph

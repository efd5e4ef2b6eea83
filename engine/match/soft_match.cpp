#include "engine/match/soft_match.h"

#include <Eigen/Core>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

using Kernel = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::ArrayXf;
using Features = Eigen::Matrix<float, Eigen::Dynamic, 6, Eigen::RowMajor>;

// The figures are chosen by hand; tests/engine/match/soft_match_test.cpp compares with a
// dense Sinkhorn iteration.

constexpr int kIterations = 25;
constexpr float kStep = 0.5f;
/// Of points to themselves. A mode of the logarithms' error that the kernel scales by 0 <= c <= 1 shrinks to 1 - step -
/// kBalance step c: to a third at most, so that 2e-5 of it are left.
constexpr int kIterationsHome = 10;
constexpr float kStepHome = 2 / 3.f;
/// Exponent of the unbalanced update [CPSV18]: below 1, mass without a partner need not be transported.
constexpr float kBalance = 0.92f;
/// A turn of the normal by 60 degrees costs as much as a distance of this many blur lengths.
constexpr double kNormalPrice = 1.1;
/// Rows or columns per task.
constexpr int kBlock = 64;

/// Per point position / blur and scaled normal, so that the cost is half the squared distance of two rows.
Features features(const OrientedPoints& points, double blur) {
  Features f(points.position.size(), 6);
  for (size_t i = 0; i < points.position.size(); ++i)
    for (int d = 0; d < 3; ++d) {
      f(Eigen::Index(i), d) = float(points.position[i][d] / blur);
      f(Eigen::Index(i), 3 + d) = float(kNormalPrice * points.normal[i][d]);
    }
  return f;
}

template <typename Body>
void overBlocks(Eigen::Index count, const Body& body) {
  tbb::parallel_for(Eigen::Index(0), (count + kBlock - 1) / kBlock, [&](Eigen::Index b) {
    const Eigen::Index first = b * kBlock;
    body(first, std::min<Eigen::Index>(kBlock, count - first));
  });
}

Kernel kernel(const Features& a, const Features& b) {
  const Vector bb = b.rowwise().squaredNorm().array();
  Kernel k(a.rows(), b.rows());
  overBlocks(a.rows(), [&](Eigen::Index first, Eigen::Index n) {
    for (Eigen::Index i = first; i < first + n; ++i) {
      const float aa = a.row(i).squaredNorm();
      k.row(i) = (((a.row(i) * b.transpose()).array() - 0.5f * bb.transpose() - 0.5f * aa).max(-60.f)).exp();
    }
  });
  return k;
}

/// Kernel times vector, each sum in a fixed order.
Vector times(const Kernel& k, const Vector& v) {
  Vector r(k.rows());
  overBlocks(k.rows(), [&](Eigen::Index first, Eigen::Index n) {
    for (Eigen::Index i = first; i < first + n; ++i) r[i] = (k.row(i).transpose() * v).sum();
  });
  return r;
}

/// Transpose times vector.
Vector transposedTimes(const Kernel& k, const Vector& u) {
  Vector r = Vector::Zero(k.cols());
  overBlocks(k.cols(), [&](Eigen::Index first, Eigen::Index n) {
    for (Eigen::Index i = 0; i < k.rows(); ++i)
      r.segment(first, n) += u[i] * k.row(i).segment(first, n).transpose();
  });
  return r;
}

/// Both products in one pass over the kernel, as reading it takes most of the time; each sum
/// in a fixed order.
void bothTimes(const Kernel& k, const Vector& v, const Vector& u, Vector& kv, Vector& ku) {
  constexpr Eigen::Index kRows = 512;
  const Eigen::Index parts = (k.rows() + kRows - 1) / kRows;
  kv.resize(k.rows());
  Kernel sums = Kernel::Zero(parts, k.cols());
  tbb::parallel_for(Eigen::Index(0), parts, [&](Eigen::Index part) {
    auto sum = sums.row(part);
    for (Eigen::Index i = part * kRows; i < std::min(k.rows(), (part + 1) * kRows); ++i) {
      const auto row = k.row(i);
      kv[i] = (row.transpose() * v).sum();
      sum += u[i] * row;
    }
  });
  ku.setZero(k.cols());
  for (Eigen::Index part = 0; part < parts; ++part) ku += sums.row(part).transpose();
}

/// One Sinkhorn update, averaged geometrically with the old scaling; `step`: the share of the new one.
Vector scaled(const Vector& mass, const Vector& sum, const Vector& old, float step) {
  return ((mass / sum.max(1e-30f)).pow(kBalance * step) * old.pow(1 - step)).min(1e15f);
}

/// The transport plan diag(u) k diag(v).
struct Transport {
  Kernel k;
  Vector u, v;
};

Transport transport(const Features& fa, const Features& fb, const Vector& ma, const Vector& mb) {
  Transport t{kernel(fa, fb), Vector::Ones(fa.rows()), Vector::Ones(fb.rows())};
  Vector kv, ku;
  for (int i = 0; i < kIterations; ++i) {
    bothTimes(t.k, t.v, t.u, kv, ku);
    t.u = scaled(ma, kv, t.u, kStep), t.v = scaled(mb, ku, t.v, kStep);
  }
  return t;
}

/// Transport of points to themselves: the kernel is symmetric, so both scalings are equal.
Transport transportHome(const Features& f, const Vector& mass) {
  Transport t{kernel(f, f), Vector::Ones(f.rows()), {}};
  for (int i = 0; i < kIterationsHome; ++i) t.u = scaled(mass, times(t.k, t.u), t.u, kStepHome);
  t.v = t.u;
  return t;
}

Vector masses(const OrientedPoints& p) {
  Vector m(p.mass.size());
  for (size_t i = 0; i < p.mass.size(); ++i) m[Eigen::Index(i)] = float(p.mass[i]);
  return m;
}

/// Per row of the plan (column if `transposed`) the mean position of the mass it sends out.
SoftTargets rowTargets(const Transport& t, const OrientedPoints& to, const Vector& mass, bool transposed) {
  Vector coordinate[3], weighted = transposed ? t.u : t.v;
  for (int d = 0; d < 3; ++d) {
    coordinate[d].resize(Eigen::Index(to.position.size()));
    for (size_t j = 0; j < to.position.size(); ++j) coordinate[d][Eigen::Index(j)] = float(to.position[j][d]);
  }
  const auto apply = [&](const Vector& v) { return transposed ? transposedTimes(t.k, v) : times(t.k, v); };
  const Vector total = apply(weighted);
  const Vector sums[3] = {apply(weighted * coordinate[0]), apply(weighted * coordinate[1]),
                          apply(weighted * coordinate[2])};
  const Vector& mine = transposed ? t.v : t.u;
  SoftTargets targets;
  for (Eigen::Index i = 0; i < total.size(); ++i) {
    const float n = std::max(total[i], 1e-30f);
    targets.position.emplace_back(sums[0][i] / n, sums[1][i] / n, sums[2][i] / n);
    targets.trust.push_back(double(mine[i]) * total[i] / std::max(mass[i], 1e-30f));
  }
  return targets;
}

/// Subtracts the bias: the displacement of a surface's transport onto itself.
void debias(SoftTargets& targets, const OrientedPoints& from, const SoftTargets& self) {
  for (size_t i = 0; i < targets.position.size(); ++i)
    targets.position[i] = from.position[i] + (targets.position[i] - self.position[i]);
}

}  // namespace

SoftMatch softMatch(const OrientedPoints& a, const OrientedPoints& b, double blur) {
  const Features fa = features(a, blur), fb = features(b, blur);
  const Vector ma = masses(a), mb = masses(b);
  SoftMatch match;
  {
    const Transport t = transport(fa, fb, ma, mb);
    match.aToB = rowTargets(t, b, ma, false);
    match.bToA = rowTargets(t, a, mb, true);
  }
  debias(match.aToB, a, rowTargets(transportHome(fa, ma), a, ma, false));
  debias(match.bToA, b, rowTargets(transportHome(fb, mb), b, mb, false));
  return match;
}

}  // namespace slicemorph

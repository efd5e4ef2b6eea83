#include "engine/match/fit_field.h"

#include <tbb/parallel_for.h>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Four columns that are solved beside each other.
using Four = Eigen::Array4f;
using FourDoubles = Eigen::Array4d;
using Column = std::vector<Four>;

struct Stencil {
  size_t base;
  float w[8];
};

/// The normal equations' operator W^T W + stiffness L^T L + a trace of the identity. Columns hold the
/// lattice's nodes within a ring of zeros.
class NormalOperator {
 public:
  NormalOperator(const Lattice& lattice, const Sites& sites, double stiffness)
      : lattice_(lattice), weight_(sites.weight), stiffness_(float(stiffness)) {
    dy_ = lattice.size[0] + 2, dz_ = dy_ * (lattice.size[1] + 2);
    for (int i = 0; i < 8; ++i) offset_[i] = (i & 1 ? 1 : 0) + (i & 2 ? dy_ : 0) + (i & 4 ? dz_ : 0);
    for (const Vec3d& p : sites.position) {
      const Vec3d q = (p - lattice.origin) / lattice.spacing;
      int b[3];
      float w[3];
      for (int a = 0; a < 3; ++a) {
        const double c = std::min(std::max(q[a], 0.0), lattice.size[a] - 1.0);
        b[a] = std::min(int(c), lattice.size[a] - 2);
        w[a] = float(c - b[a]);
      }
      Stencil s;
      s.base = index(b[0], b[1], b[2]);
      for (int i = 0; i < 8; ++i)
        s.w[i] = (i & 1 ? w[0] : 1 - w[0]) * (i & 2 ? w[1] : 1 - w[1]) * (i & 4 ? w[2] : 1 - w[2]);
      stencils_.push_back(s);
    }
  }

  size_t index(int x, int y, int z) const { return size_t(x + 1) + (y + 1) * dy_ + (z + 1) * dz_; }
  Column zero() const { return Column(dz_ * (lattice_.size[2] + 2), Four::Zero()); }

  /// `values(i)`: the four columns' values at site i.
  template <typename Values>
  Column rightHandSide(const Values& values) const {
    Column b = zero();
    for (size_t i = 0; i < stencils_.size(); ++i) {
      const Four v = values(i);
      for (int c = 0; c < 8; ++c) b[stencils_[i].base + offset_[c]] += (weight_[i] * stencils_[i].w[c]) * v;
    }
    return b;
  }

  /// y = this times x; `scratch` and `y` are of the same size and zero in the ring.
  void operator()(const Column& x, Column& scratch, Column& y) const {
    laplacian(x, scratch);
    laplacian(scratch, y);
    forEachRow([&](size_t n, size_t end) {
      for (; n < end; ++n) y[n] = stiffness_ * y[n] + 1e-5f * x[n];
    });
    for (size_t i = 0; i < stencils_.size(); ++i) {
      const Stencil& s = stencils_[i];
      Four v = Four::Zero();
      for (int c = 0; c < 8; ++c) v += s.w[c] * x[s.base + offset_[c]];
      v *= weight_[i];
      for (int c = 0; c < 8; ++c) y[s.base + offset_[c]] += s.w[c] * v;
    }
  }

 private:
  /// The first node of every row, and the one after its last.
  template <typename Body>
  void forEachRow(const Body& body) const {
    for (int z = 0; z < lattice_.size[2]; ++z)
      for (int y = 0; y < lattice_.size[1]; ++y) body(index(0, y, z), index(lattice_.size[0], y, z));
  }

  void laplacian(const Column& x, Column& y) const {
    forEachRow([&](size_t n, size_t end) {
      for (; n < end; ++n)
        y[n] = x[n] - (x[n - 1] + x[n + 1] + x[n - dy_] + x[n + dy_] + x[n - dz_] + x[n + dz_]) / 6;
    });
  }

  const Lattice& lattice_;
  const std::vector<float>& weight_;
  float stiffness_;
  size_t dy_, dz_;
  std::vector<Stencil> stencils_;
  size_t offset_[8];
};

FourDoubles dot(const Column& a, const Column& b) {
  FourDoubles s = FourDoubles::Zero();
  for (size_t i = 0; i < a.size(); ++i) s += a[i].cast<double>() * b[i].cast<double>();
  return s;
}

/// Conjugate gradients, each column for itself.
Column solve(const NormalOperator& op, const Column& b, Column x) {
  Column scratch = op.zero(), q = op.zero(), r = op.zero();
  op(x, scratch, q);
  for (size_t i = 0; i < r.size(); ++i) r[i] = b[i] - q[i];
  Column p = r;
  FourDoubles rr = dot(r, r);
  const FourDoubles enough = 1e-6 * dot(b, b).max(1e-30);
  for (int iteration = 0; iteration < 80 && (rr > enough).any(); ++iteration) {
    op(p, scratch, q);
    const FourDoubles pq = dot(p, q);
    const auto goesOn = rr > enough && pq > 0;
    if (!goesOn.any()) break;
    const Four alpha = goesOn.select(rr / pq, 0.0).cast<float>();
    for (size_t i = 0; i < x.size(); ++i) x[i] += alpha * p[i], r[i] -= alpha * q[i];
    const FourDoubles next = dot(r, r);
    const Four beta = goesOn.select(next / rr, 0.0).cast<float>();
    rr = next;
    for (size_t i = 0; i < p.size(); ++i) p[i] = r[i] + beta * p[i];
  }
  return x;
}

}  // namespace

Displacements fitFields(const Lattice& lattice, const Sites& sites, double stiffness,
                        const Displacements& start) {
  const size_t objects = sites.value.size();
  const NormalOperator op(lattice, sites, stiffness);
  Displacements result{lattice, start.of};
  // The fit is linear: the last object follows from the others and from the sum of all, which mostly is
  // nothing.
  std::vector<Vec3d> sums(sites.position.size(), Vec3d(0.0));
  VectorField sum(lattice.count(), openvdb::Vec3s(0.f));
  double most = 0, largest = 0;
  for (size_t k = 0; k < objects; ++k) {
    for (size_t i = 0; i < sums.size(); ++i) {
      sums[i] += sites.value[k][i];
      largest = std::max(largest, sites.value[k][i].lengthSqr());
    }
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += start.of[k][i];
  }
  for (const Vec3d& s : sums) most = std::max(most, s.lengthSqr());
  for (const auto& s : sum) most = std::max(most, double(s.lengthSqr()));
  const bool bowed = most > 1e-8 * largest;
  if (!bowed) std::fill(sum.begin(), sum.end(), openvdb::Vec3s(0.f));
  const size_t columns = 3 * (objects - 1 + bowed);
  tbb::parallel_for(size_t(0), (columns + 3) / 4, [&](size_t four) {
    const auto forEachColumn = [&](const auto& body) {
      for (int lane = 0; lane < 4; ++lane)
        if (const size_t column = 4 * four + lane; column < columns) body(lane, column / 3, int(column % 3));
    };
    const auto forEachNode = [&](const auto& body) {
      for (int z = 0; z < lattice.size[2]; ++z)
        for (int y = 0; y < lattice.size[1]; ++y)
          for (int x = 0; x < lattice.size[0]; ++x) body(lattice.index(x, y, z), op.index(x, y, z));
    };
    Column first = op.zero();
    forEachColumn([&](int lane, size_t object, int component) {
      const VectorField& from = object == objects - 1 ? sum : start.of[object];
      forEachNode([&](size_t node, size_t ringed) { first[ringed][lane] = from[node][component]; });
    });
    const Column wanted = op.rightHandSide([&](size_t site) {
      Four value = Four::Zero();
      forEachColumn([&](int lane, size_t object, int component) {
        value[lane] = float((object == objects - 1 ? sums : sites.value[object])[site][component]);
      });
      return value;
    });
    const Column x = solve(op, wanted, std::move(first));
    forEachColumn([&](int lane, size_t object, int component) {
      VectorField& to = object == objects - 1 ? sum : result.of[object];
      forEachNode([&](size_t node, size_t ringed) { to[node][component] = x[ringed][lane]; });
    });
  });
  for (size_t i = 0; i < lattice.count(); ++i) {
    result.of.back()[i] = sum[i];
    for (size_t k = 0; k + 1 < objects; ++k) result.of.back()[i] -= result.of[k][i];
  }
  return result;
}

}  // namespace slicemorph

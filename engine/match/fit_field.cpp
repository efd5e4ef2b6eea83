#include "engine/match/fit_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

struct Stencil {
  size_t base;
  float w[8];
};

/// The normal equations' operator W^T W + stiffness L^T L + a trace of the identity, for one component.
class NormalOperator {
 public:
  NormalOperator(const Lattice& lattice, const Sites& sites, double stiffness)
      : lattice_(lattice), weight_(sites.weight), stiffness_(float(stiffness)) {
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
      s.base = lattice.index(b[0], b[1], b[2]);
      for (int i = 0; i < 8; ++i)
        s.w[i] = (i & 1 ? w[0] : 1 - w[0]) * (i & 2 ? w[1] : 1 - w[1]) * (i & 4 ? w[2] : 1 - w[2]);
      stencils_.push_back(s);
    }
    const size_t dy = lattice.size[0], dz = dy * lattice.size[1];
    for (int i = 0; i < 8; ++i) offset_[i] = (i & 1 ? 1 : 0) + (i & 2 ? dy : 0) + (i & 4 ? dz : 0);
  }

  std::vector<float> rightHandSide(const std::vector<Vec3d>& values, int component) const {
    std::vector<float> b(lattice_.count(), 0.f);
    for (size_t i = 0; i < stencils_.size(); ++i)
      for (int c = 0; c < 8; ++c)
        b[stencils_[i].base + offset_[c]] += weight_[i] * stencils_[i].w[c] * float(values[i][component]);
    return b;
  }

  std::vector<float> operator()(const std::vector<float>& x) const {
    std::vector<float> y = laplacian(laplacian(x));
    for (size_t i = 0; i < y.size(); ++i) y[i] = stiffness_ * y[i] + 1e-5f * x[i];
    for (size_t i = 0; i < stencils_.size(); ++i) {
      float v = 0;
      for (int c = 0; c < 8; ++c) v += stencils_[i].w[c] * x[stencils_[i].base + offset_[c]];
      v *= weight_[i];
      for (int c = 0; c < 8; ++c) y[stencils_[i].base + offset_[c]] += stencils_[i].w[c] * v;
    }
    return y;
  }

 private:
  std::vector<float> laplacian(const std::vector<float>& x) const {
    std::vector<float> y(x.size());
    const int nx = lattice_.size[0], ny = lattice_.size[1], nz = lattice_.size[2];
    const size_t dy = nx, dz = size_t(nx) * ny;
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j) {
        const size_t row = lattice_.index(0, j, k);
        for (int i = 0; i < nx; ++i) {
          const size_t n = row + i;
          float s = 0;
          if (i > 0) s += x[n - 1];
          if (i + 1 < nx) s += x[n + 1];
          if (j > 0) s += x[n - dy];
          if (j + 1 < ny) s += x[n + dy];
          if (k > 0) s += x[n - dz];
          if (k + 1 < nz) s += x[n + dz];
          y[n] = x[n] - s / 6;
        }
      }
    return y;
  }

  const Lattice& lattice_;
  const std::vector<float>& weight_;
  float stiffness_;
  std::vector<Stencil> stencils_;
  size_t offset_[8];
};

double dot(const std::vector<float>& a, const std::vector<float>& b) {
  double s = 0;
  for (size_t i = 0; i < a.size(); ++i) s += double(a[i]) * b[i];
  return s;
}

std::vector<float> solve(const NormalOperator& op, const std::vector<float>& b, std::vector<float> x) {
  std::vector<float> r = op(x);
  for (size_t i = 0; i < r.size(); ++i) r[i] = b[i] - r[i];
  std::vector<float> p = r;
  double rr = dot(r, r);
  const double enough = 1e-6 * std::max(dot(b, b), 1e-30);
  for (int iteration = 0; iteration < 80 && rr > enough; ++iteration) {
    const std::vector<float> q = op(p);
    const double pq = dot(p, q);
    if (!(pq > 0)) break;
    const float alpha = float(rr / pq);
    for (size_t i = 0; i < x.size(); ++i) x[i] += alpha * p[i], r[i] -= alpha * q[i];
    const double next = dot(r, r);
    const float beta = float(next / rr);
    rr = next;
    for (size_t i = 0; i < p.size(); ++i) p[i] = r[i] + beta * p[i];
  }
  return x;
}

}  // namespace

Displacements fitFields(const Lattice& lattice, const Sites& sites, double stiffness, const Displacements& start) {
  const size_t objects = sites.value.size();
  const NormalOperator op(lattice, sites, stiffness);
  Displacements result{lattice, start.of};
  // The fit is linear: the last object follows from the others and from the sum of all, which mostly is nothing.
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
  tbb::parallel_for(size_t(0), 3 * (objects - 1 + bowed), [&](size_t task) {
    const size_t object = task / 3;
    const int component = int(task % 3);
    const bool last = object == objects - 1;
    const VectorField& from = last ? sum : start.of[object];
    std::vector<float> x(lattice.count());
    for (size_t i = 0; i < x.size(); ++i) x[i] = from[i][component];
    x = solve(op, op.rightHandSide(last ? sums : sites.value[object], component), std::move(x));
    VectorField& to = last ? sum : result.of[object];
    for (size_t i = 0; i < x.size(); ++i) to[i][component] = x[i];
  });
  for (size_t i = 0; i < lattice.count(); ++i) {
    result.of.back()[i] = sum[i];
    for (size_t k = 0; k + 1 < objects; ++k) result.of.back()[i] -= result.of[k][i];
  }
  return result;
}

}  // namespace slicemorph

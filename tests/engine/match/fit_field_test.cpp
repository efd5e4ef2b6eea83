// Fitted fields against the dense normal equations of the functional they minimise.
#include "engine/match/fit_field.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

const Lattice kLattice{{-1, 0, 2}, 0.5, {5, 4, 6}};

Displacements zeroOn(const Lattice& lattice, size_t objects) {
  return {lattice, std::vector<VectorField>(objects, VectorField(lattice.count(), openvdb::Vec3s(0.f)))};
}

/// Sites in and around the lattice; the values of all objects sum to zero or not.
Sites randomSites(size_t count, size_t objects, bool sumToZero) {
  std::mt19937 random(11);
  std::uniform_real_distribution<> uniform(-1, 1);
  Sites sites;
  sites.value.resize(objects);
  for (size_t i = 0; i < count; ++i) {
    sites.position.push_back(Vec3d(0, 0.75, 3.25) +
                             Vec3d(1.2 * uniform(random), 0.9 * uniform(random), 1.4 * uniform(random)));
    sites.weight.push_back(float(1.01 + uniform(random)));
    Vec3d sum(0.0);
    for (size_t k = 0; k < objects; ++k) {
      const Vec3d v(uniform(random), uniform(random), uniform(random));
      sites.value[k].push_back(sumToZero && k + 1 == objects ? -sum : v);
      sum += v;
    }
  }
  return sites;
}

/// W as a matrix: trilinear weights of the nodes at every site, which is drawn onto the lattice.
Eigen::MatrixXd interpolation(const Sites& sites) {
  Eigen::MatrixXd w =
      Eigen::MatrixXd::Zero(Eigen::Index(sites.position.size()), Eigen::Index(kLattice.count()));
  for (size_t i = 0; i < sites.position.size(); ++i)
    for (int z = 0; z < kLattice.size[2]; ++z)
      for (int y = 0; y < kLattice.size[1]; ++y)
        for (int x = 0; x < kLattice.size[0]; ++x) {
          double hat = 1;
          for (int a = 0; a < 3; ++a) {
            const double q = (sites.position[i][a] - kLattice.origin[a]) / kLattice.spacing;
            const double c = std::min(std::max(q, 0.0), kLattice.size[a] - 1.0);
            hat *= std::max(0.0, 1 - std::abs(c - openvdb::Coord(x, y, z)[a]));
          }
          w(Eigen::Index(i), Eigen::Index(kLattice.index(x, y, z))) = hat;
        }
  return w;
}

/// L as a matrix: a node's value less the mean of its six neighbours', zero beyond the lattice.
Eigen::MatrixXd laplacian() {
  Eigen::MatrixXd l =
      Eigen::MatrixXd::Identity(Eigen::Index(kLattice.count()), Eigen::Index(kLattice.count()));
  for (int z = 0; z < kLattice.size[2]; ++z)
    for (int y = 0; y < kLattice.size[1]; ++y)
      for (int x = 0; x < kLattice.size[0]; ++x)
        for (int a = 0; a < 3; ++a)
          for (int side : {-1, 1}) {
            openvdb::Coord n(x, y, z);
            n[a] += side;
            if (n[a] < 0 || n[a] >= kLattice.size[a]) continue;
            l(Eigen::Index(kLattice.index(x, y, z)), Eigen::Index(kLattice.index(n[0], n[1], n[2]))) =
                -1 / 6.0;
          }
  return l;
}

Eigen::VectorXd columnOf(const VectorField& field, int component) {
  Eigen::VectorXd x{Eigen::Index(field.size())};
  for (size_t i = 0; i < field.size(); ++i) x[Eigen::Index(i)] = double(field[i][component]);
  return x;
}

/// The gradient of the functional at the fitted fields, W^T w (W x - v) + stiffness L^T L x, against that at
/// nothing: conjugate gradients end at a thousandth of it, and the last object, which follows from the others
/// and their sum, has the errors of all.
void expectMinimal(const Sites& sites, double stiffness, const Displacements& fitted) {
  const size_t objects = sites.value.size();
  const Eigen::MatrixXd w = interpolation(sites), l = laplacian();
  Eigen::VectorXd weight(Eigen::Index(sites.weight.size()));
  for (size_t i = 0; i < sites.weight.size(); ++i) weight[Eigen::Index(i)] = double(sites.weight[i]);
  const Eigen::MatrixXd a = w.transpose() * weight.asDiagonal() * w + stiffness * l.transpose() * l;
  for (int component = 0; component < 3; ++component) {
    double largest = 0;
    std::vector<Eigen::VectorXd> right;
    Eigen::VectorXd all = Eigen::VectorXd::Zero(a.rows());
    for (size_t k = 0; k < objects; ++k) {
      Eigen::VectorXd v(Eigen::Index(sites.position.size()));
      for (size_t i = 0; i < sites.position.size(); ++i) v[Eigen::Index(i)] = sites.value[k][i][component];
      right.push_back(w.transpose() * weight.cwiseProduct(v));
      all += right.back();
      largest = std::max(largest, right.back().norm());
    }
    for (size_t k = 0; k < objects; ++k) {
      const Eigen::VectorXd x = columnOf(fitted.of[k], component);
      const double terms = k + 1 < objects ? 1 : double(objects);
      // A trace of 1e-5 of the identity, and sums in single precision.
      const double rest = 1e-5 * x.norm() + 1e-5 * (a * x).norm();
      EXPECT_LE((a * x - right[k]).norm(), 1e-3 * terms * std::max(largest, all.norm()) + rest)
          << "object " << k << ", component " << component;
    }
  }
}

TEST(FitField, MinimisesItsFunctional) {
  for (double stiffness : {0.01, 0.3, 5.0})
    for (size_t objects : {1u, 2u, 3u, 5u})
      for (bool sumToZero : {true, false}) {
        const Sites sites = randomSites(60, objects, sumToZero && objects > 1);
        expectMinimal(sites, stiffness, fitFields(kLattice, sites, stiffness, zeroOn(kLattice, objects)));
      }
}

/// Where the search starts does not matter.
TEST(FitField, MinimisesItFromAnywhere) {
  const Sites sites = randomSites(60, 2, false);
  Displacements start = zeroOn(kLattice, 2);
  std::mt19937 random(2);
  for (VectorField& field : start.of)
    for (openvdb::Vec3s& v : field)
      for (int a = 0; a < 3; ++a) v[a] = std::uniform_real_distribution<float>(-3, 3)(random);
  expectMinimal(sites, 0.3, fitFields(kLattice, sites, 0.3, start));
}

/// An affine field that is given at all nodes, with a weight much greater than the stiffness, is met: what is
/// left comes from the lattice's rim, where it breaks off. (w + s L^T L) x = w v differs from v by at most
/// (s / w) |L|^2 |v| with |L| <= 2, and the search by a thousandth more.
TEST(FitField, ReproducesAffineFields) {
  const double stiffness = 0.3, weight = 300;
  const auto affine = [](const Vec3d& p) {
    return Vec3d(0.3 + p[0] - 0.2 * p[1], 0.1 * p[2], -0.4 + 0.5 * p[1] - p[0]);
  };
  Sites sites;
  sites.value.resize(2);
  double size = 0;
  for (int z = 0; z < kLattice.size[2]; ++z)
    for (int y = 0; y < kLattice.size[1]; ++y)
      for (int x = 0; x < kLattice.size[0]; ++x) {
        const Vec3d p = kLattice.position(x, y, z);
        sites.position.push_back(p), sites.weight.push_back(float(weight));
        sites.value[0].push_back(affine(p)), sites.value[1].push_back(-affine(p));
        size += affine(p).lengthSqr();
      }
  const Displacements fitted = fitFields(kLattice, sites, stiffness, zeroOn(kLattice, 2));
  for (int k = 0; k < 2; ++k) {
    double off = 0;
    for (size_t i = 0; i < sites.position.size(); ++i)
      off += (Vec3d(fitted.of[size_t(k)][i]) - sites.value[size_t(k)][i]).lengthSqr();
    EXPECT_LE(std::sqrt(off), (4 * stiffness / weight + 1e-3 + 1e-5) * std::sqrt(size)) << k;
  }
}

}  // namespace
}  // namespace slicemorph

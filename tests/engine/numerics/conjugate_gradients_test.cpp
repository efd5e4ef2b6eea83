#include "engine/numerics/conjugate_gradients.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <random>

namespace slicemorph {
namespace {

/// A dense matrix whose unknowns are some nodes of a longer field.
class DenseSystem {
 public:
  DenseSystem(Eigen::MatrixXd a, std::vector<size_t> nodes, bool preconditioned, size_t grain)
      : a_(std::move(a)), nodes_(std::move(nodes)), preconditioned_(preconditioned), grain_{grain} {}

  size_t size() const { return nodes_.size(); }
  size_t node(size_t i) const { return nodes_[i]; }
  float diagonal(size_t i) const { return preconditioned_ ? float(a_(Eigen::Index(i), Eigen::Index(i))) : 1; }
  Grain grain() const { return grain_; }
  void apply(const std::vector<float>& field, std::vector<float>& product) const {
    for (size_t i = 0; i < nodes_.size(); ++i) {
      double sum = 0;
      for (size_t j = 0; j < nodes_.size(); ++j)
        sum += a_(Eigen::Index(i), Eigen::Index(j)) * double(field[nodes_[j]]);
      product[i] = float(sum);
    }
  }

 private:
  Eigen::MatrixXd a_;
  std::vector<size_t> nodes_;
  bool preconditioned_;
  Grain grain_;
};

/// Eigenvalues from 1 to about 5; if `scaled`, rows of very different magnitude.
Eigen::MatrixXd matrix(int n, bool scaled) {
  std::srand(1);
  const Eigen::MatrixXd r = Eigen::MatrixXd::Random(n, n);
  Eigen::MatrixXd a = Eigen::MatrixXd::Identity(n, n) + 3.0 / n * r * r.transpose();
  for (int i = 0; i < n && scaled; ++i) {
    const double s = 1 + i % 7;
    a.row(i) *= s, a.col(i) *= s;
  }
  return a;
}

std::vector<size_t> everySecond(size_t n) {
  std::vector<size_t> nodes(n);
  for (size_t i = 0; i < n; ++i) nodes[i] = 2 * i + 1;
  return nodes;
}

/// `field` is zero except for the fixed nodes, which are 5.
std::vector<float> solved(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, bool preconditioned,
                          size_t grain, GradientSettings settings, int* steps = nullptr) {
  const size_t n = size_t(b.size());
  DenseSystem system(a, everySecond(n), preconditioned, grain);
  std::vector<float> field(2 * n, 0.0f), residual(n);
  for (size_t i = 0; i < n; ++i) field[2 * i] = 5, residual[i] = float(b[Eigen::Index(i)]);
  const int taken = conjugateGradients(system, settings, residual, field);
  if (steps) *steps = taken;
  return field;
}

TEST(ConjugateGradients, SolveWhatADirectSolverSolves) {
  for (bool scaled : {false, true})
    for (bool preconditioned : {false, true}) {
      const int n = 60;
      const Eigen::MatrixXd a = matrix(n, scaled);
      const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(n, -3, 4), x = a.ldlt().solve(b);
      const std::vector<float> field = solved(a, b, preconditioned, 1000, {400, 1e-12});
      double off = 0;
      for (int i = 0; i < n; ++i) {
        off = std::max(off, std::abs(double(field[size_t(2 * i + 1)]) - x[i]));
        EXPECT_EQ(field[size_t(2 * i)], 5) << "held";
      }
      // A relative residual of a millionth leaves an error of that times the condition number, 250 if scaled;
      // single precision adds about as much.
      EXPECT_LT(off, 1e-6 * (scaled ? 500 : 10) * x.norm()) << scaled << preconditioned;
    }
}

/// In exact arithmetic the number of steps is that of different eigenvalues; a diagonal matrix,
/// preconditioned by its diagonal, takes one.
TEST(ConjugateGradients, TakeAStepForEachEigenvalue) {
  Eigen::VectorXd diagonal(30);
  for (int i = 0; i < 30; ++i) diagonal[i] = 1 + i % 3;
  const Eigen::MatrixXd a = diagonal.asDiagonal();
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(30, 1, 2);
  int steps = 0;
  solved(a, b, false, 1000, {100, 1e-9}, &steps);
  EXPECT_EQ(steps, 3);
  solved(a, b, true, 1000, {100, 1e-9}, &steps);
  EXPECT_EQ(steps, 1);
}

TEST(ConjugateGradients, StopAfterTheirSteps) {
  int steps = 0;
  const Eigen::MatrixXd a = matrix(60, true);
  solved(a, Eigen::VectorXd::Ones(60), false, 1000, {4, 0}, &steps);
  EXPECT_EQ(steps, 4);
  solved(a, Eigen::VectorXd::Zero(60), false, 1000, {4, 0}, &steps);
  EXPECT_EQ(steps, 0) << "solved already";
}

TEST(ConjugateGradients, GiveTheSameBytesForAnyNumberOfThreads) {
  const Eigen::MatrixXd a = matrix(200, true);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(200, -1, 2);
  std::vector<std::vector<float>> found;
  for (size_t threads : {1, 2, 4})
    withThreads(threads, [&] { found.push_back(solved(a, b, true, 16, {30, 0})); });
  EXPECT_EQ(found[0], found[1]);
  EXPECT_EQ(found[0], found[2]);
}

}  // namespace
}  // namespace slicemorph

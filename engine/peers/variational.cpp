#include "engine/peers/variational.h"

#include "engine/numerics/readable.h"
#include "engine/peers/full_fields.h"
#include "engine/peers/function_level_set.h"
#include "engine/peers/require.h"
#include "engine/volume/distance_field.h"
#include "slicemorph/errors.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace slicemorph {
namespace {

/// How deep the constraints inside are, in diagonals of the objects' box.
constexpr double kInside = 0.01;

double cubed(double square) { return square * std::sqrt(square); }

double squareApart(const Weights& a, const Weights& b, double apart) {
  double sum = 0;
  for (size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return apart * apart / 2 * sum;
}

/// So many samples of a surface, each as far from those before as there is one.
std::vector<SurfaceSample> spreadSamples(const std::vector<SurfaceSample>& samples, int count) {
  std::vector<SurfaceSample> spread;
  std::vector<double> nearest(samples.size(), std::numeric_limits<double>::max());
  size_t next = 0;
  while (int(spread.size()) < count && nearest[next] > 0) {
    spread.push_back(samples[next]);
    for (size_t i = 0; i < samples.size(); ++i)
      nearest[i] = std::min(nearest[i], (samples[i].position - spread.back().position).lengthSqr());
    next = size_t(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
  }
  return spread;
}

void refuseConstraints(size_t constraints) {
  if (constraints > VariationalMorph::kMostConstraints)
    throw InputError("--method variational: two constraints for each point on each input are " +
                     readableCount(double(constraints)) + "; " +
                     readableCount(double(VariationalMorph::kMostConstraints)) +
                     " at most: choose smaller points=");
}

void refuseWork(const openvdb::BBoxd& box, double voxelSize, size_t constraints) {
  const Vec3d size = box.extents() / voxelSize;
  const double work = size[0] * size[1] * size[2] * double(constraints);
  if (!(work <= VariationalMorph::kMostWork))
    throw InputError(
        "--method variational: every voxel of the box about its shape sums over all constraints, " +
        readableCount(work) + " terms here; " + readableCount(VariationalMorph::kMostWork) +
        " at most: choose a larger --voxel-size, a smaller --resolution or smaller points=");
}

}  // namespace

VariationalFunction::VariationalFunction(const std::vector<VariationalConstraint>& constraints, double apart)
    : constraints_(constraints), apart_(apart) {
  const Eigen::Index n = Eigen::Index(constraints.size()),
                     m = 3 + Eigen::Index(constraints[0].weights.size());
  Eigen::MatrixXd cubes(n, n), affine(n, m);
  Eigen::VectorXd values(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const VariationalConstraint& at = constraints[size_t(i)];
    values[i] = at.value;
    for (Eigen::Index a = 0; a < m; ++a) affine(i, a) = a < 3 ? at.point[int(a)] : at.weights[size_t(a - 3)];
    for (Eigen::Index j = 0; j < n; ++j) {
      const VariationalConstraint& other = constraints[size_t(j)];
      cubes(i, j) =
          cubed((at.point - other.point).lengthSqr() + squareApart(at.weights, other.weights, apart));
    }
  }
  // Factors are orthogonal to all affine functions. Among those the cubes' matrix is positive definite.
  const Eigen::HouseholderQR<Eigen::MatrixXd> split(affine);
  Eigen::MatrixXd turned = split.householderQ().adjoint() * cubes;
  turned = turned * split.householderQ();
  const Eigen::VectorXd turnedValues = split.householderQ().adjoint() * values;
  Eigen::VectorXd factors = Eigen::VectorXd::Zero(n);
  factors.tail(n - m) = turned.bottomRightCorner(n - m, n - m).ldlt().solve(turnedValues.tail(n - m));
  const Eigen::VectorXd rest = turnedValues.head(m) - turned.topRightCorner(m, n - m) * factors.tail(n - m);
  const Eigen::VectorXd slopes =
      split.matrixQR().topLeftCorner(m, m).triangularView<Eigen::Upper>().solve(rest);
  factors = split.householderQ() * factors;
  factors_.assign(factors.data(), factors.data() + n);
  slope_ = Vec3d(slopes[0], slopes[1], slopes[2]);
  perWeight_.assign(slopes.data() + 3, slopes.data() + m);
}

VariationalFunction::Slice::Slice(const VariationalFunction& whole, const Weights& weights) : whole_(&whole) {
  for (const VariationalConstraint& at : whole.constraints_)
    squares_.push_back(squareApart(weights, at.weights, whole.apart_));
  for (size_t k = 0; k < weights.size(); ++k) constant_ += whole.perWeight_[k] * weights[k];
}

double VariationalFunction::Slice::operator()(const Vec3d& p) const {
  double sum = constant_ + whole_->slope_.dot(p);
  for (size_t i = 0; i < squares_.size(); ++i)
    sum += whole_->factors_[i] * cubed((p - whole_->constraints_[i].point).lengthSqr() + squares_[i]);
  return sum;
}

VariationalMorph::VariationalMorph(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                                   const VariationalOptions& options, Progress* progress)
    : inputs_(levelSets.size()), voxelSize_(voxelSize) {
  refuseConstraints(2 * size_t(options.points) * inputs_);
  std::vector<std::vector<SurfaceSample>> samples;
  for (size_t k = 0; k < inputs_; ++k) {
    reportOrCancel(progress, "choosing points", 0.5 * double(k) / double(inputs_));
    const DistanceField field(levelSets[k]);
    samples.push_back(spreadSamples(field.samples(), options.points));
    box_.expand(field.box());
  }
  const double diagonal = box_.extents().length();
  std::vector<VariationalConstraint> constraints;
  for (size_t k = 0; k < inputs_; ++k) {
    Weights own(inputs_, 0.0);
    own[k] = 1;
    for (const SurfaceSample& sample : samples[k]) {
      constraints.push_back({sample.position, own, 0});
      constraints.push_back({sample.position - kInside * diagonal * sample.normal, own, -kInside * diagonal});
    }
  }
  // In-betweens may bulge.
  const Vec3d margin = 0.1 * box_.extents() + Vec3d(4 * voxelSize);
  box_ = openvdb::BBoxd(box_.min() - margin, box_.max() + margin);
  refuseWork(box_, voxelSize, constraints.size());
  reportOrCancel(progress, "solving for the function", 0.5);
  function_.emplace(constraints, options.apart * diagonal / 2);
}

FloatGrid::Ptr VariationalMorph::frame(const Weights& weights) const {
  requireWeights(weights, inputs_);
  const VariationalFunction::Slice slice(*function_, weights);
  return levelSetOfFunction({box_, voxelSize_, "variational"},
                            [&] { return [&](const Vec3d& p) { return float(slice(p)); }; });
}

}  // namespace slicemorph

#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/progress.h"

#include <optional>
#include <vector>

namespace slicemorph {

struct VariationalOptions {
  /// Points on each object's surface, each with one inside.
  int points = 300;
  /// How far objects are from each other in the further dimensions, in half diagonals of their box.
  double apart = 1;
};

/// A value that a function shall have at a point of space and of the weights' space.
struct VariationalConstraint {
  Vec3d point;
  Weights weights;
  double value;
};

/// The function through all constraints that bends least [TO99]: a sum of |x - x_i|^3 and an affine function.
class VariationalFunction {
 public:
  /// `apart`: distance between two objects' places in the weights' space, where weights are coordinates; world units.
  /// Constraints must not lie in one plane of space and weights together, and those of a place must be different points.
  VariationalFunction(const std::vector<VariationalConstraint>& constraints, double apart);

  /// At weights, what is left is a function of space.
  class Slice {
   public:
    Slice(const VariationalFunction& whole, const Weights& weights);
    double operator()(const Vec3d& p) const;

   private:
    const VariationalFunction* whole_;
    std::vector<double> squares_;  ///< of distances to constraints in the weights' space
    double constant_ = 0;
  };

 private:
  std::vector<VariationalConstraint> constraints_;
  double apart_;
  std::vector<double> factors_;  ///< of the cubes
  Vec3d slope_;
  std::vector<double> perWeight_;  ///< of the affine function; weights sum to 1, so it needs no constant
};

/// Morph by one implicit function through the surfaces of all objects, which lie apart in further dimensions [TO99]: a
/// slice between them is the in-between.
class VariationalMorph {
 public:
  /// `voxelSize`: world units. Throws InputError where there are more than kMostConstraints, or where constraints times
  /// voxels are more than kMostWork; Cancelled.
  VariationalMorph(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                   const VariationalOptions& options = {}, Progress* progress = nullptr);
  /// A level set named "surface". Throws InputError unless there is one weight per level set.
  FloatGrid::Ptr frame(const Weights& weights) const;

  static constexpr size_t kMostConstraints = 5000;  ///< 200 MB while they are solved for
  static constexpr double kMostWork = 1e10;

 private:
  size_t inputs_;
  double voxelSize_;
  openvdb::BBoxd box_;
  std::optional<VariationalFunction> function_;
};

}  // namespace slicemorph

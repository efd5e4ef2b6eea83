#include "engine/peers/bounded_blend.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// A displacement over a gap's length can change by so many times more than the distances that it is made of.
constexpr double kSteepestBlend = 8;

double diagonalOfAll(const std::vector<FloatGrid::ConstPtr>& levelSets) {
  openvdb::BBoxd box;
  for (const auto& levelSet : levelSets)
    box.expand(levelSet->transform().indexToWorld(levelSet->evalActiveVoxelBoundingBox()));
  return box.extents().length();
}

/// R-function of an intersection: positive where both are.
double bothOf(double a, double b) { return a + b - std::hypot(a, b); }

}  // namespace

double boundedUnion(const std::vector<double>& functions, const Weights& weights, double bound, double most,
                    double width) {
  const double joined = *std::max_element(functions.begin(), functions.end());
  if (bound <= 0) return joined;
  double mean = 0;
  for (size_t k = 0; k < functions.size(); ++k)
    mean += weights[k] * (functions[k] / width) * (functions[k] / width);
  const double square = std::max(mean, 0.0) / (std::max(mean, 0.0) + bound * bound), rest = 1 - square;
  return joined + most * rest * rest * rest / (1 + square);
}

BoundedBlend::BoundedBlend(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                           const BoundedBlendOptions& options, Progress* progress)
    : fields_(levelSets, voxelSize, "bounded-blend", progress),
      options_(options),
      gap_(options.gap * diagonalOfAll(levelSets)) {}

FloatGrid::Ptr BoundedBlend::frame(const Weights& weights) const {
  fields_.requireWeights(weights);
  const double untilOwnTime = gap_ * (1 - *std::max_element(weights.begin(), weights.end()));
  const double most = options_.strength * gap_ * double(weights.size()) / 2;
  return fields_.levelSetOf(
      [&](const std::vector<const float*>& distances, float* values) {
        std::vector<double> cylinders(weights.size());
        for (openvdb::Index i = 0; i < FullFields::kLeafValues; ++i) {
          double nearest = double(distances[0][i]);
          for (size_t k = 0; k < weights.size(); ++k) {
            const double lasts = gap_ * (weights[k] - 1 + options_.stay);
            cylinders[k] = bothOf(-double(distances[k][i]), lasts);
            nearest = std::min(nearest, double(distances[k][i]));
          }
          const double bound = std::min(untilOwnTime, gap_ - nearest);
          values[i] = -float(boundedUnion(cylinders, weights, bound, most, options_.width));
        }
      },
      kSteepestBlend);
}

}  // namespace slicemorph

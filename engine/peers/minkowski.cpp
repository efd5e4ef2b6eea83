#include "engine/peers/minkowski.h"

#include "engine/numerics/readable.h"
#include "engine/peers/full_fields.h"
#include "engine/peers/function_level_set.h"
#include "engine/peers/require.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

/// An object is convex if its hull is larger by less than this share.
constexpr double kDents = 0.01;

/// Per direction the vertex that is furthest out.
std::vector<openvdb::Vec3s> furthestVertices(const Mesh& mesh, const RingLayout& layout) {
  std::vector<openvdb::Vec3s> furthest(layout.count());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, layout.count(), 16), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      const openvdb::Vec3s direction(layout.direction(i));
      float most = std::numeric_limits<float>::lowest();
      for (const openvdb::Vec3s& p : mesh.points)
        if (const float reach = direction.dot(p); reach > most) most = reach, furthest[i] = p;
    }
  });
  return furthest;
}

double enclosedVolume(const std::vector<openvdb::Vec3s>& points,
                      const std::vector<openvdb::Vec3I>& triangles) {
  double six = 0;
  for (const openvdb::Vec3I& t : triangles) {
    const Vec3d origin(points[0]);
    const Vec3d a = Vec3d(points[t[0]]) - origin, b = Vec3d(points[t[1]]) - origin;
    six += a.cross(b).dot(Vec3d(points[t[2]]) - origin);
  }
  return six / 6;
}

/// An object scaled about the world's origin.
struct ScaledObject {
  const DistanceField* field;
  double scale;

  openvdb::BBoxd box() const { return {scale * field->box().min(), scale * field->box().max()}; }
};

/// A copy of one of two objects, moved to a surface point of the other.
struct MovedCopy {
  bool first;  ///< a copy of the first object
  Vec3d offset;
};

std::vector<MovedCopy> movedCopies(const ScaledObject& a, const ScaledObject& b) {
  std::vector<MovedCopy> copies;
  for (const SurfaceSample& sample : b.field->samples()) copies.push_back({true, b.scale * sample.position});
  for (const SurfaceSample& sample : a.field->samples()) copies.push_back({false, a.scale * sample.position});
  return copies;
}

/// The distance to the union of all copies. (What is missing of the sum when only the first object is moved along the
/// second one's surface are points from which the first lies wholly inside the second; those the other copies cover.)
/// Points must come leaf by leaf: for each leaf, what is nearest at its middle is near the rest.
class UnionOfCopies {
 public:
  UnionOfCopies(const ScaledObject& a, const ScaledObject& b, const std::vector<MovedCopy>& copies,
                double voxelSize)
      : objects_{b, a},
        samplers_{DistanceField::Sampler(*b.field), DistanceField::Sampler(*a.field)},
        copies_(copies),
        side_(8 * voxelSize) {}

  float operator()(const Vec3d& p) {
    const openvdb::Coord leaf = openvdb::Coord::floor(p / side_ + Vec3d(1.0 / 16));
    if (leaf != leaf_ || near_.empty()) enter(leaf);
    // 10 voxels: the band, and a voxel more than from the middle of a leaf to its corner. Far values are dropped.
    if (std::abs(middle_) > 10.0f / 8 * float(side_)) return std::copysign(1000 * float(side_), middle_);
    const Vec3d middle = side_ * (leaf.asVec3d() + Vec3d(7.0 / 16));
    const int part = (p[0] > middle[0]) + 2 * (p[1] > middle[1]) + 4 * (p[2] > middle[2]);
    if (parts_[part].empty()) enterPart(part, middle);
    float nearest = std::numeric_limits<float>::max();
    for (const MovedCopy* copy : parts_[part]) nearest = std::min(nearest, distance(*copy, p));
    return nearest;
  }

 private:
  float distance(const MovedCopy& copy, const Vec3d& p) const {
    const ScaledObject& object = objects_[copy.first];
    return float(object.scale) *
           samplers_[copy.first](object.field->relative((p - copy.offset) / object.scale));
  }
  /// Copies that are further away at the middle than others, by more than all distances change up to the leaf's corners,
  /// are nowhere the nearest.
  void enter(const openvdb::Coord& leaf) {
    leaf_ = leaf;
    const Vec3d middle = side_ * (leaf.asVec3d() + Vec3d(7.0 / 16));
    std::vector<float> distances;
    for (const MovedCopy& copy : copies_) distances.push_back(distance(copy, middle));
    middle_ = *std::min_element(distances.begin(), distances.end());
    near_.clear();
    for (auto& part : parts_) part.clear();
    for (size_t i = 0; i < copies_.size(); ++i)
      if (distances[i] <= middle_ + 14.0f / 8 * float(side_)) near_.push_back(&copies_[i]);
  }

  /// The same for the voxels of an eighth of the leaf, with corners 2.6 voxels from its middle.
  void enterPart(int part, const Vec3d& leafMiddle) {
    const Vec3d side(part & 1 ? 1 : -1, part & 2 ? 1 : -1, part & 4 ? 1 : -1);
    const Vec3d middle = leafMiddle + side_ / 4 * side;
    std::vector<float> distances;
    for (const MovedCopy* copy : near_) distances.push_back(distance(*copy, middle));
    const float nearest = *std::min_element(distances.begin(), distances.end());
    for (size_t i = 0; i < near_.size(); ++i)
      if (distances[i] <= nearest + 7.0f / 8 * float(side_)) parts_[part].push_back(near_[i]);
  }

  ScaledObject objects_[2];  ///< second, first
  DistanceField::Sampler samplers_[2];
  const std::vector<MovedCopy>& copies_;
  double side_;  ///< of a leaf
  openvdb::Coord leaf_;
  float middle_ = 0;                               ///< distance at the leaf's middle
  std::vector<const MovedCopy*> near_, parts_[8];  ///< of the leaf, and of its eighths as they are asked for
};

void refuseFineSum(const openvdb::BBoxd& box, double voxelSize) {
  const Vec3d size = box.extents() / voxelSize;
  const double voxels = size[0] * size[1] * size[2];
  if (!(voxels <= MinkowskiMorph::kMostVoxels))
    throw InputError(
        "--method minkowski: not all inputs are convex, and the sum of others is searched for at " +
        readableCount(voxels) + " voxels here; " + readableCount(MinkowskiMorph::kMostVoxels) +
        " at most: choose a larger --voxel-size or a smaller --resolution");
}

FloatGrid::Ptr sumOf(const ScaledObject& a, const ScaledObject& b, double voxelSize) {
  const openvdb::BBoxd box(a.box().min() + b.box().min(), a.box().max() + b.box().max());
  refuseFineSum(box, voxelSize);
  const std::vector<MovedCopy> copies = movedCopies(a, b);
  return levelSetOfFunction({box, voxelSize, "minkowski"}, [&] {
    const auto at = std::make_shared<UnionOfCopies>(a, b, copies, voxelSize);
    return [at](const Vec3d& p) { return (*at)(p); };
  });
}

FloatGrid::Ptr scaledLevelSet(const ScaledObject& object, double voxelSize) {
  return levelSetOfFunction({object.box(), voxelSize, "minkowski"}, [&] {
    return [object, sample = DistanceField::Sampler(*object.field)](const Vec3d& p) {
      return float(object.scale) * sample(object.field->relative(p / object.scale));
    };
  });
}

}  // namespace

MinkowskiMorph::MinkowskiMorph(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                               const MinkowskiOptions& options, Progress* progress)
    : voxelSize_(voxelSize) {
  layout_.around = 4 * options.directions, layout_.rings = 2 * options.directions - 1;
  const std::vector<openvdb::Vec3I> triangles = layout_.triangles();
  for (size_t k = 0; k < levelSets.size(); ++k) {
    reportOrCancel(progress, "measuring in all directions", double(k) / double(levelSets.size()));
    fields_.push_back(std::make_shared<DistanceField>(levelSets[k]));
    const Mesh mesh = surfaceOf(*levelSets[k]);
    furthest_.push_back(furthestVertices(mesh, layout_));
    convex_ &=
        enclosedVolume(furthest_[k], triangles) <= (1 + kDents) * enclosedVolume(mesh.points, mesh.triangles);
  }
}

FloatGrid::Ptr MinkowskiMorph::frame(const Weights& weights) const {
  requireWeights(weights, fields_.size());
  for (const double weight : weights)
    if (!(weight >= 0))
      throw InputError(
          "--method minkowski: a weight is below 0, as where splines through keys overshoot; sums need "
          "weights of 0 or more");
  return convex_ ? convexSum(weights) : gridSum(weights);
}

FloatGrid::Ptr MinkowskiMorph::convexSum(const Weights& weights) const {
  Mesh mesh;
  for (size_t i = 0; i < layout_.count(); ++i) {
    Vec3d sum(0.0);
    for (size_t k = 0; k < weights.size(); ++k) sum += weights[k] * Vec3d(furthest_[k][i]);
    mesh.points.emplace_back(sum);
  }
  // Where all objects have corners, many directions have the same point.
  for (const openvdb::Vec3I& t : layout_.triangles())
    if (mesh.points[t[0]] != mesh.points[t[1]] && mesh.points[t[1]] != mesh.points[t[2]] &&
        mesh.points[t[2]] != mesh.points[t[0]])
      mesh.triangles.push_back(t);
  return levelSetOfMesh(mesh, voxelSize_);
}

FloatGrid::Ptr MinkowskiMorph::gridSum(const Weights& weights) const {
  std::shared_ptr<const DistanceField> sum;
  FloatGrid::Ptr levelSet;
  double scale = 0;  ///< of `sum`
  for (size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] == 0) continue;
    if (sum) {
      levelSet = sumOf({sum.get(), scale}, {fields_[k].get(), weights[k]}, voxelSize_);
      sum = std::make_shared<DistanceField>(levelSet), scale = 1;
    } else {
      sum = fields_[k], scale = weights[k];
    }
  }
  return levelSet ? levelSet : scaledLevelSet({sum.get(), scale}, voxelSize_);
}

}  // namespace slicemorph

#pragma once

#include "engine/conventions.h"

#include <openvdb/tree/ValueAccessor.h>

namespace slicemorph {

/// Distance to one object's surface at any point of space: the level set's own values in its narrow band, and beyond
/// it a true distance from a coarse closest-point transform. A clamped band would make unmatched parts pop; a true
/// distance lets them shrink.
class DistanceField {
 public:
  /// `levelSet`: by the conventions, with a surface. `nodes`: of the coarse grid along the object's longest side.
  explicit DistanceField(FloatGrid::ConstPtr levelSet, int nodes = 112);

  const FloatGrid& levelSet() const { return *levelSet_; }
  double voxelSize() const { return voxelSize_; }
  /// Box of the surface, world units.
  const openvdb::BBoxd& box() const { return box_; }

  /// Distance from the coarse grid alone (exact to a few hundredths of a coarse cell), world units.
  float coarse(const Vec3d& world) const;
  /// Surface point closest to a world point, exact to about one fine voxel.
  Vec3d closest(const Vec3d& world) const;
  /// Unit gradient of the coarse distance.
  Vec3d gradient(const Vec3d& world) const;

  /// Coarse nodes: for passes over the whole object.
  const openvdb::Coord& size() const { return size_; }
  double spacing() const { return spacing_; }
  Vec3d nodePosition(int x, int y, int z) const { return origin_ + spacing_ * Vec3d(x, y, z); }
  float nodeDistance(int x, int y, int z) const { return distance_[index(x, y, z)]; }

  /// Fine sampling; one per task, for its cache is not shared.
  class Sampler {
   public:
    explicit Sampler(const DistanceField& field) : field_(&field), accessor_(field.levelSet_->tree()) {}
    /// Signed distance at a world point, world units.
    float operator()(const Vec3d& world);

   private:
    friend class DistanceField;
    float fine(const Vec3d& index);
    const DistanceField* field_;
    openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor_;
  };

 private:
  size_t index(int x, int y, int z) const { return (size_t(z) * size_[1] + y) * size_[0] + x; }
  void seedFromBand();
  void sweep();
  void signDistances();

  FloatGrid::ConstPtr levelSet_;
  double voxelSize_ = 0;
  Vec3d fineOrigin_;
  openvdb::BBoxd box_;
  openvdb::Coord size_;
  double spacing_ = 0;
  Vec3d origin_;
  std::vector<float> distance_;
  std::vector<openvdb::Vec3s> closest_;
};

/// A point of an object's surface with the area it stands for.
struct SurfaceSample {
  Vec3d position;  ///< world
  Vec3d normal;    ///< unit, outwards
  double area = 0; ///< world units squared
};

/// About `count` samples spread evenly over the surface.
std::vector<SurfaceSample> sampleSurface(const DistanceField& field, int count);

}  // namespace slicemorph

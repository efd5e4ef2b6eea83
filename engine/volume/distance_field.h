#pragma once

#include "engine/conventions.h"

#include <openvdb/tree/ValueAccessor.h>

namespace slicemorph {

/// A point of an object's surface with the area it stands for.
struct SurfaceSample {
  Vec3d position;  ///< world
  Vec3d normal;    ///< unit, outwards
  double area = 0; ///< world units squared
};

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
  float coarse(const Vec3d& world) const { return coarseAt(openvdb::Vec3s((world - origin_) / spacing_)); }
  /// Surface point closest to a world point, exact to about one fine voxel.
  Vec3d closest(const Vec3d& world) const;
  /// Unit gradient of the coarse distance.
  Vec3d gradient(const Vec3d& world) const;

  /// Some 8,000 samples spread evenly over the surface.
  const std::vector<SurfaceSample>& samples() const { return samples_; }

  /// Coarse nodes: for passes over the whole object.
  const openvdb::Coord& size() const { return size_; }
  double spacing() const { return spacing_; }
  Vec3d nodePosition(int x, int y, int z) const { return origin_ + spacing_ * Vec3d(x, y, z); }
  float nodeDistance(int x, int y, int z) const { return distance_[index(x, y, z)]; }

  /// Fine sampling at points given in some affine frame; one per task, for its cache is not shared.
  class Sampler {
   public:
    /// Points p stand for the world points linear * p + origin.
    Sampler(const DistanceField& field, const Mat3d& linear, const Vec3d& origin);
    /// Points are world points.
    explicit Sampler(const DistanceField& field) : Sampler(field, Mat3d::identity(), Vec3d(0.0)) {}
    /// Signed distance, world units.
    float operator()(const openvdb::Vec3s& p);
    /// From the coarse grid alone.
    float coarse(const openvdb::Vec3s& p) const { return field_->coarseAt(toCoarse_(p)); }

   private:
    friend class DistanceField;
    struct Affine {
      float m[9], o[3];
      Affine(const Mat3d& linear, const Vec3d& origin);
      openvdb::Vec3s operator()(const openvdb::Vec3s& p) const {
        return {m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + o[0], m[3] * p[0] + m[4] * p[1] + m[5] * p[2] + o[1],
                m[6] * p[0] + m[7] * p[1] + m[8] * p[2] + o[2]};
      }
    };
    float fine(const openvdb::Vec3s& index);
    const DistanceField* field_;
    Affine toCoarse_, toFine_;
    openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor_;
  };

 private:
  float coarseAt(const openvdb::Vec3s& index) const;
  size_t index(int x, int y, int z) const { return (size_t(z) * size_[1] + y) * size_[0] + x; }
  void seedFromBand();
  void sweep();
  void signDistances();
  void sampleSurface(int count);

  FloatGrid::ConstPtr levelSet_;
  double voxelSize_ = 0;
  Vec3d fineOrigin_;
  openvdb::BBoxd box_;
  openvdb::Coord size_;
  double spacing_ = 0;
  Vec3d origin_;
  std::vector<float> distance_;
  std::vector<openvdb::Vec3s> closest_;
  std::vector<SurfaceSample> samples_;
};

}  // namespace slicemorph

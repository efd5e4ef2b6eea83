#pragma once

#include "engine/numerics/lattice.h"

#include <array>

namespace slicemorph {

/// A point of an object's surface with the area it stands for.
struct SurfaceSample {
  Vec3d position;   ///< world
  Vec3d normal;     ///< unit, outwards
  double area = 0;  ///< world units squared
};

/// Bin of a surface point among cubes of side `cell` from `origin`. Opposite sides of a thin part must not
/// fall into one: a bin holds normals of one main direction only.
using SurfaceBin = std::array<int, 4>;
SurfaceBin surfaceBin(const Vec3d& position, const Vec3d& normal, const Vec3d& origin, double cell);

/// A level set's narrow band for fast sampling: its leaves with one voxel of their neighbours on the far
/// sides, found through a table over the box of all leaves. No lookup leaves its block, none needs a cache.
class BandBlocks {
 public:
  explicit BandBlocks(const FloatGrid& levelSet);
  /// Trilinear value at an index-space point relative to origin(); beyond all blocks `unknown`.
  float operator()(const openvdb::Vec3s& index, float unknown) const;
  /// Gradient of the same, per voxel; zero beyond all blocks.
  openvdb::Vec3s gradient(const openvdb::Vec3s& index) const;
  /// Index-space point that the places count from.
  const openvdb::Coord& origin() const { return origin_; }

 private:
  static constexpr int kSide = 9, kBlock = kSide * kSide * kSide;
  /// Values around a point, and how far it lies between them; null beyond all blocks.
  const float* cell(const openvdb::Vec3s& index, openvdb::Vec3s& between) const;

  openvdb::Coord origin_, size_;  ///< of the table, in voxels and in leaves
  std::vector<int> block_;        ///< per leaf of the table; -1: none
  std::vector<float> values_;
};

/// Distance to one object's surface at any point of space: the level set's own values in its narrow band, and
/// beyond it a true distance from a coarse closest-point transform. A clamped band would make unmatched parts
/// pop; a true distance lets them shrink.
class DistanceField {
 public:
  /// `levelSet`: by the conventions, with a surface. `nodes`: of the coarse grid along the object's longest
  /// side.
  explicit DistanceField(FloatGrid::ConstPtr levelSet, int nodes = 112);

  const FloatGrid& levelSet() const { return *levelSet_; }
  double voxelSize() const { return voxelSize_; }
  /// Box of the surface, world units.
  const openvdb::BBoxd& box() const { return box_; }
  /// The box's middle. Places in single precision are relative to it, so that an object far from the world's
  /// origin loses no digits.
  const Vec3d& anchor() const { return anchor_; }
  openvdb::Vec3s relative(const Vec3d& world) const { return openvdb::Vec3s(world - anchor_); }

  /// Distance from the coarse grid alone (exact to a few hundredths of a coarse cell), world units.
  float coarse(const Vec3d& world) const {
    return coarseAt(openvdb::Vec3s((world - nodes_.origin) / nodes_.spacing));
  }
  /// Surface point closest to a world point, exact to about one fine voxel.
  Vec3d closest(const Vec3d& world) const;
  /// Unit gradient of the coarse distance.
  Vec3d gradient(const Vec3d& world) const;

  /// Some 8,000 samples spread evenly over the surface.
  const std::vector<SurfaceSample>& samples() const { return samples_; }

  /// Coarse nodes: for passes over the whole object.
  const Lattice& nodes() const { return nodes_; }
  const openvdb::Coord& size() const { return nodes_.size; }
  double spacing() const { return nodes_.spacing; }
  Vec3d nodePosition(int x, int y, int z) const { return nodes_.position(x, y, z); }
  float nodeDistance(int x, int y, int z) const { return distance_[nodes_.index(x, y, z)]; }

  /// Sampling at points relative to the anchor, in single precision.
  class Sampler {
   public:
    explicit Sampler(const DistanceField& field);
    /// Signed distance, world units.
    float operator()(const openvdb::Vec3s& p) const;
    /// From the coarse grid alone.
    float coarse(const openvdb::Vec3s& p) const { return field_->coarseAt(p * coarseScale_ + coarseOrigin_); }
    /// Unit gradient: of the level set's own values in its band, beyond it of the coarse grid.
    openvdb::Vec3s gradient(const openvdb::Vec3s& p) const;

   private:
    const DistanceField* field_;
    float voxelSize_, coarseScale_, fineScale_;
    openvdb::Vec3s coarseOrigin_, fineOrigin_;
  };

 private:
  float coarseAt(const openvdb::Vec3s& index) const;
  void seedFromBand();
  void sweep();
  void signDistances();
  void sampleSurface(int count);

  FloatGrid::ConstPtr levelSet_;
  double voxelSize_ = 0;
  BandBlocks band_;
  openvdb::BBoxd box_;
  Vec3d anchor_;
  Lattice nodes_;  ///< of the coarse grid, in the world
  std::vector<float> distance_;
  std::vector<openvdb::Vec3s> closest_;
  std::vector<SurfaceSample> samples_;
};

}  // namespace slicemorph

#pragma once

#include "engine/numerics/lattice.h"

#include <array>

namespace slicemorph {

/// A point on an object's surface with the area that it represents.
struct SurfaceSample {
  Vec3d position;   ///< world
  Vec3d normal;     ///< unit, outwards
  double area = 0;  ///< world units squared
};

/// Bin of a surface point among cubes of side `cell` whose grid starts at `origin`. Each cube has one bin per
/// main direction of the normal, so that opposite sides of a thin part do not share a bin.
using SurfaceBin = std::array<int, 4>;
SurfaceBin surfaceBin(const Vec3d& position, const Vec3d& normal, const Vec3d& origin, double cell);

/// A level set's narrow band laid out for fast sampling: each leaf is copied with one layer of voxels of its
/// upper neighbours and found through a table over the box of all leaves. Trilinear sampling then reads one
/// block only and needs no accessor.
class BandBlocks {
 public:
  explicit BandBlocks(const FloatGrid& levelSet);
  /// Trilinear value at a point, in voxels relative to origin(); `unknown` outside all blocks.
  float operator()(const openvdb::Vec3s& index, float unknown) const;
  /// Gradient of the same, per voxel; zero outside all blocks.
  openvdb::Vec3s gradient(const openvdb::Vec3s& index) const;
  /// Index-space point to which sampled points are relative.
  const openvdb::Coord& origin() const { return origin_; }

 private:
  static constexpr int kSide = 9, kBlock = kSide * kSide * kSide;
  /// The first of the eight values around a point; `between` gets the point's offset from it, 0 to 1 per
  /// axis. Null outside all blocks.
  const float* cell(const openvdb::Vec3s& index, openvdb::Vec3s& between) const;

  openvdb::Coord origin_, size_;  ///< first voxel of the table, and its size in leaves
  std::vector<int> block_;        ///< per leaf of the table; -1: none
  std::vector<float> values_;
};

/// Signed distance to one object's surface, anywhere in space: the level set's own values in its narrow band,
/// and beyond it a true distance from a coarse closest-point transform. With a clamped band, parts without a
/// partner would pop in and out; with a true distance they shrink.
class DistanceField {
 public:
  /// `levelSet`: follows the conventions and has a surface, else GeometryError. `nodes`: number of coarse
  /// nodes along the object's longest side.
  explicit DistanceField(FloatGrid::ConstPtr levelSet, int nodes = 112);

  const FloatGrid& levelSet() const { return *levelSet_; }
  double voxelSize() const { return voxelSize_; }
  /// Bounding box of the surface, world units.
  const openvdb::BBoxd& box() const { return box_; }
  /// Centre of the box. Positions in single precision are relative to it, so that an object far from the
  /// world's origin loses no digits.
  const Vec3d& anchor() const { return anchor_; }
  openvdb::Vec3s relative(const Vec3d& world) const { return openvdb::Vec3s(world - anchor_); }

  /// Distance from the coarse grid alone, world units; exact to a few hundredths of a coarse cell.
  float coarse(const Vec3d& world) const {
    return coarseAt(openvdb::Vec3s((world - nodes_.origin) / nodes_.spacing));
  }
  /// The surface point closest to a world point, exact to about one fine voxel.
  Vec3d closest(const Vec3d& world) const;
  /// Unit gradient of the coarse distance.
  Vec3d gradient(const Vec3d& world) const;

  /// About 8,000 samples, spread evenly over the surface.
  const std::vector<SurfaceSample>& samples() const { return samples_; }

  /// The coarse nodes, for passes over the whole object.
  const Lattice& nodes() const { return nodes_; }
  const openvdb::Coord& size() const { return nodes_.size; }
  double spacing() const { return nodes_.spacing; }
  Vec3d nodePosition(int x, int y, int z) const { return nodes_.position(x, y, z); }
  float nodeDistance(int x, int y, int z) const { return distance_[nodes_.index(x, y, z)]; }

  /// Samples at points relative to the anchor, in single precision.
  class Sampler {
   public:
    explicit Sampler(const DistanceField& field);
    /// Signed distance, world units.
    float operator()(const openvdb::Vec3s& p) const;
    /// The same from the coarse grid alone.
    float coarse(const openvdb::Vec3s& p) const { return field_->coarseAt(p * coarseScale_ + coarseOrigin_); }
    /// Unit gradient: of the level set's values within its band, of the coarse grid beyond it.
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
  Lattice nodes_;  ///< of the coarse grid, world space
  std::vector<float> distance_;
  std::vector<openvdb::Vec3s> closest_;
  std::vector<SurfaceSample> samples_;
};

}  // namespace slicemorph

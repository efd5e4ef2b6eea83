#pragma once

#include "engine/frame/align.h"

namespace slicemorph {

/// The shares, 0 to 1, by which positions belong to a morph's regions.
class RegionShares {
 public:
  RegionShares() = default;
  /// `regions`: refer to the objects of `fields` and `charts`. `drawn`: the charts at the time when the
  /// regions were given; spheres and boxes move along with objects that have moved since.
  RegionShares(std::vector<Region> regions, const Fields& fields, const std::vector<Chart>& charts,
               const std::vector<Chart>& drawn);

  size_t count() const { return regions_.size(); }
  const Region& region(size_t r) const { return regions_[r]; }
  /// Share at a world position on the region's object, relative to the field's anchor: 1 well inside, 0 well
  /// outside, smoothstep in between.
  float at(size_t r, const openvdb::Vec3s& position) const;
  /// Signed distance to the region's boundary at a world position on its object, world units;
  /// negative inside.
  double distance(size_t r, const Vec3d& world) const;
  /// Whether the region contains any part of its object.
  bool holdsAnything(size_t r, const DistanceField& field) const;

 private:
  struct Spine {
    double low = 0, length = 1;  ///< the object's extent along its spine: z0 times its scale, world units
    bool reversed = false;       ///< the region is measured from the other end
  };

  std::vector<Region> regions_;
  std::vector<Chart> charts_;   ///< per region: its object's
  std::vector<Chart> drawn_;    ///< per region: the same when it was drawn
  std::vector<char> moved_;     ///< per region: whether these differ
  std::vector<Vec3d> anchor_;   ///< per region
  std::vector<Spine> spine_;    ///< per region
  std::vector<double> border_;  ///< per region, world units
};

/// The objects' weights at each position of one in-between: those of the whole, changed in the regions.
class LocalWeights {
 public:
  LocalWeights() = default;
  /// `regions`: null if weights are the same everywhere. Must outlive this.
  LocalWeights(Weights whole, const RegionShares* regions);

  const Weights& whole() const { return whole_; }
  bool vary() const { return regions_ && regions_->count() > 0; }
  /// Objects with a weight somewhere, or on which a region is defined.
  std::vector<size_t> used() const;
  /// Objects on which regions are defined.
  std::vector<size_t> regionObjects() const;
  /// Writes the weights of one point, which is at `positions[k]` on object k (relative to its anchor); only
  /// the positions on regionObjects() are read.
  void find(const openvdb::Vec3s* positions, double* weights) const;
  /// The same from the point's shares, one per region.
  void blend(const float* shares, double* weights) const;

 private:
  Weights whole_;
  const RegionShares* regions_ = nullptr;
};

}  // namespace slicemorph

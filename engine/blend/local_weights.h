#pragma once

#include "engine/frame/align.h"

namespace slicemorph {

/// Which share of a place lies in each of a morph's regions.
class RegionShares {
 public:
  RegionShares() = default;
  /// `regions`: their objects and weights are those of `fields` and `charts`. `drawn`: the charts when
  /// regions were drawn, where objects have moved since: spheres and boxes go along with them.
  RegionShares(std::vector<Region> regions, const Fields& fields, const std::vector<Chart>& charts,
               const std::vector<Chart>& drawn);

  size_t count() const { return regions_.size(); }
  const Region& region(size_t r) const { return regions_[r]; }
  /// Of a place on the region's object, relative to its field's anchor: 1 well inside, 0 well outside, smooth
  /// between.
  float at(size_t r, const openvdb::Vec3s& place) const;
  /// World units to its rim on its own object, negative inside.
  double distance(size_t r, const Vec3d& world) const;
  /// Whether it holds anything of its own object.
  bool holdsAnything(size_t r, const DistanceField& field) const;

 private:
  struct Spine {
    double low = 0, length = 1;  ///< of the object along its spine: z0 times its scale
    bool reversed = false;
  };

  std::vector<Region> regions_;
  std::vector<Chart> charts_;   ///< per region: its object's
  std::vector<Chart> drawn_;    ///< per region: the same when it was drawn
  std::vector<char> moved_;     ///< per region: whether these differ
  std::vector<Vec3d> anchor_;   ///< per region
  std::vector<Spine> spine_;    ///< per region
  std::vector<double> border_;  ///< per region, world units
};

/// The objects' weights at each place of one in-between: those of the whole, and those of its regions.
class LocalWeights {
 public:
  LocalWeights() = default;
  /// `regions`: null: the same everywhere. Must outlive this.
  LocalWeights(Weights whole, const RegionShares* regions);

  const Weights& whole() const { return whole_; }
  bool vary() const { return regions_ && regions_->count() > 0; }
  /// Objects that count somewhere or tell where regions are.
  std::vector<size_t> used() const;
  /// Objects on which regions are drawn.
  std::vector<size_t> regionObjects() const;
  /// The weights of one place, `places[k]` on object k relative to its anchor; only those on regionObjects()
  /// are looked at.
  void find(const openvdb::Vec3s* places, double* weights) const;
  /// The same from the shares of its regions.
  void blend(const float* shares, double* weights) const;

 private:
  Weights whole_;
  const RegionShares* regions_ = nullptr;
};

}  // namespace slicemorph

#pragma once

#include "engine/rebuild/warp_image.h"

namespace slicemorph {

/// Near surfaces, shifts the positions at which the images are sampled so that every image is sampled at the
/// same depth inside its own object.
class MatchDepths {
 public:
  /// Both arguments must outlive this.
  MatchDepths(const std::vector<CarriedImage>& images, const ImageNodes& nodes);

  /// Whether a surface may pass through the cell whose first node is `node`. Depths need
  /// no matching elsewhere.
  bool near(const openvdb::Coord& node) const {
    return !near_.empty() && near_[nodes_.map.index(node[0], node[1], node[2])];
  }

  struct Position {
    openvdb::Vec3s at;   ///< world units, relative to the anchor of the image's distance field
    float distance = 0;  ///< signed distance of the image's object there, world units
  };
  /// Fills in the distances. One position per image.
  void measure(std::vector<Position>& positions) const;

  /// Whether a surface may pass near the straight segments between two sets of measured positions.
  bool near(const std::vector<Position>& first, const std::vector<Position>& last) const;

  /// What the in-between has at a voxel; world units of the in-between.
  struct Match {
    float distance = 0;  ///< signed, of its surface
    float shift = 0;     ///< by how much the images' depths there are shifted, in the weighted mean
  };
  /// Moves the measured positions of one voxel (one per image) to where their depths agree.
  Match match(std::vector<Position>& positions) const;

 private:
  /// Voxels on either side of the surface within which depths are matched: the half width of the narrow band.
  /// Guarded by MatchingFadesWithDepth in match_depths_test.cpp.
  static constexpr double kReach = 3;
  openvdb::Vec3s moved(size_t image, const Position& position, float level) const;
  void findCells();

  const std::vector<CarriedImage>& images_;
  const ImageNodes& nodes_;
  std::vector<DistanceField::Sampler> samplers_;
  float reach_ = 0;         ///< kReach in world units of the in-between
  std::vector<char> near_;  ///< per cell, indexed by its first node
};

}  // namespace slicemorph

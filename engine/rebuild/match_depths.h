#pragma once

#include "engine/rebuild/warp_image.h"

namespace slicemorph {

/// Finds positions of like depth in images near the surfaces of the in-between and of their objects.
class MatchDepths {
 public:
  /// Both must outlive this.
  MatchDepths(const std::vector<CarriedImage>& images, const ImageNodes& nodes);

  /// Whether a surface may pass the cell that begins at a node. Elsewhere depths need no matching.
  bool near(const openvdb::Coord& node) const {
    return !near_.empty() && near_[nodes_.map.index(node[0], node[1], node[2])];
  }

  struct Position {
    openvdb::Vec3s at;   ///< world units, relative to the anchor of the image's field
    float distance = 0;  ///< there, of its object
  };
  /// One position per image, with their distances.
  void measure(std::vector<Position>& positions) const;

  /// Whether a surface may pass near the straight lines between two measured positions.
  bool near(const std::vector<Position>& first, const std::vector<Position>& last) const;

  /// Moves measured positions of one voxel to such of like depth. Returns the in-between's distance there, world
  /// units.
  float match(std::vector<Position>& positions) const;

 private:
  /// Voxels around the surface in which depths are matched.
  static constexpr double kReach = 3;
  openvdb::Vec3s moved(size_t image, const Position& position, float level) const;
  void findCells();

  const std::vector<CarriedImage>& images_;
  const ImageNodes& nodes_;
  std::vector<DistanceField::Sampler> samplers_;
  float reach_ = 0;         ///< world units of the in-between
  std::vector<char> near_;  ///< per cell, by its first node
};

}  // namespace slicemorph

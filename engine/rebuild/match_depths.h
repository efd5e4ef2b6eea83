#pragma once

#include "engine/rebuild/warp_image.h"

namespace slicemorph {

/// Finds places of like depth in images near the surfaces of the in-between and of their objects.
class MatchDepths {
 public:
  /// Both must outlive this.
  MatchDepths(const std::vector<CarriedImage>& images, const ImageNodes& nodes);

  /// Whether a surface may pass the cell that begins at a node. Elsewhere depths need no matching.
  bool near(const openvdb::Coord& node) const {
    return !near_.empty() && near_[nodes_.map.index(node[0], node[1], node[2])];
  }

  struct Place {
    openvdb::Vec3s at;   ///< world units, relative to the anchor of the image's field
    float distance = 0;  ///< there, of its object
  };
  /// One place per image, with their distances.
  void measure(std::vector<Place>& places) const;

  /// Whether a surface may pass near the straight lines between two measured places.
  bool near(const std::vector<Place>& first, const std::vector<Place>& last) const;

  /// Moves measured places of one voxel to such of like depth. Returns the in-between's distance there, world
  /// units.
  float match(std::vector<Place>& places) const;

 private:
  /// Voxels around the surface in which depths are matched.
  static constexpr double kReach = 3;
  openvdb::Vec3s moved(size_t image, const Place& place, float level) const;
  void findCells();

  const std::vector<CarriedImage>& images_;
  const ImageNodes& nodes_;
  std::vector<DistanceField::Sampler> samplers_;
  float reach_ = 0;         ///< world units of the in-between
  std::vector<char> near_;  ///< per cell, by its first node
};

}  // namespace slicemorph

#pragma once

#include "engine/rebuild/warp_grid.h"
#include "engine/volume/distance_field.h"
#include "engine/volume/label_field.h"

#include <optional>

namespace slicemorph {

/// Nodes that carry a dense lattice: every step[d]-th voxel along axis d.
struct ImageNodes {
  openvdb::Vec3i step{1, 1, 1};
  NodeMap map;  ///< index space: that of the nodes, steps apart
};

/// About as fine as the matching's lattice: no more can be told.
ImageNodes imageNodes(const ImageLattice& on, const Carrying& carrying, double spacing);

/// One object's image, carried along by the map of its shape.
struct CarriedImage {
  const Image* image = nullptr;
  size_t shape = 0;           ///< which object of the node map it rides with
  Vec3d anchor{0, 0, 0};      ///< of that object's field
  double weight = 0;
  const DistanceField* field = nullptr;  ///< of the object; null: places alone are matched, not depths
  double size = 1;            ///< of the in-between against the object
  std::optional<double> iso = std::nullopt;  ///< the value at its surface; where all are known the in-between's surface has their blend
};

/// sum_k w_k V_k(M_k(p)), trilinear, slice by slice; see Carrier::carry. Near the surfaces every image is looked up where it
/// is as deep inside its object as the in-between is, along the way to its surface: thin walls that do not lie quite on each
/// other stay whole, and what is outside the in-between shows no ghost of one image's inside.
Image warpImages(const std::vector<CarriedImage>& images, const ImageNodes& nodes, const ImageLattice& on);

/// An image at the voxels of another lattice, trilinear; beyond it its smallest value. Where voxels coincide values are kept.
Image resampledTo(const Image& image, const ImageLattice& on);

struct CarriedLabels {
  const LabelField* labels = nullptr;
  size_t shape = 0;
  Vec3d anchor{0, 0, 0};
  double weight = 0;  ///< with the object's size against the in-between's: depths count in its units
};

/// The deepest label at every voxel; see Carrier::carryLabels. As uint8, uint16 or int32, whichever holds all.
Image warpLabels(const std::vector<CarriedLabels>& labels, const ImageNodes& nodes, const ImageLattice& on);

/// A label map at the voxels of another lattice: that of the nearest voxel.
Image nearestTo(const Image& labels, const ImageLattice& on);

}  // namespace slicemorph

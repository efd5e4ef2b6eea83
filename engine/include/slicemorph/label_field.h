#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// Depth inside each label of a label map: one signed distance field per label, in a box around it.
class LabelField {
 public:
  /// Throws InputError if the image's values are not labels (see labelsOf in engine/volume/image_shape.h).
  explicit LabelField(const Image& labels);

  struct Label {
    std::int64_t value = 0;
    openvdb::CoordBBox box;       ///< voxels for which distances are stored: the label's own and a margin
    std::vector<float> distance;  ///< world units, positive inside; i fastest
    float deepest = 0;            ///< the largest of them
  };

  const ImageLattice& lattice() const { return lattice_; }
  const std::vector<Label>& labels() const { return labels_; }
  /// The union of all labels: where labels meet, none of them alone is deep.
  const Label& all() const { return all_; }
  const Label* find(std::int64_t value) const;

  /// Signed depth inside a label (world units, positive inside) at a point in voxel coordinates, trilinear.
  /// Beyond the label's box the distance to the box is subtracted.
  float depth(const Label& label, const openvdb::Vec3f& voxel) const;

  /// Appends to `found`, and sorts, the labels (indices into labels()) with voxels in or near a
  /// box of voxels.
  void labelsNear(const openvdb::CoordBBox& box, std::vector<int>& found) const;

 private:
  ImageLattice lattice_;
  openvdb::Vec3f spacing_;
  std::vector<Label> labels_;
  Label all_;
  openvdb::Coord blocks_;
  std::vector<std::vector<int>> inBlock_;  ///< per block of voxels: the labels with voxels in it
};

}  // namespace slicemorph

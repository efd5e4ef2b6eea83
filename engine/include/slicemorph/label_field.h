#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// How deep inside every label of a map each place is: one signed distance per label, in a box around it.
class LabelField {
 public:
  /// Throws InputError where the image's values are no labels.
  explicit LabelField(const Image& labels);

  struct Label {
    std::int64_t value = 0;
    openvdb::CoordBBox box;       ///< voxels that hold distances
    std::vector<float> distance;  ///< world units, positive inside; i fastest
    float deepest = 0;            ///< the largest of them
  };

  const ImageLattice& lattice() const { return lattice_; }
  const std::vector<Label>& labels() const { return labels_; }
  /// Depth inside all of them together: where labels meet, none of them alone is deep.
  const Label& all() const { return all_; }
  const Label* find(std::int64_t value) const;

  /// Depth inside a label at a place in voxels, trilinear; beyond its box less by the way to the box.
  float depth(const Label& label, const openvdb::Vec3f& voxel) const;

  /// Labels (indices into labels(), ascending) that have voxels in a box of voxels, or near it.
  void labelsNear(const openvdb::CoordBBox& box, std::vector<int>& found) const;

 private:
  ImageLattice lattice_;
  openvdb::Vec3f spacing_;
  std::vector<Label> labels_;
  Label all_;
  openvdb::Coord blocks_;
  std::vector<std::vector<int>> inBlock_;  ///< labels with voxels in a block
};

}  // namespace slicemorph

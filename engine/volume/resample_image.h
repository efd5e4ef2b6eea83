#pragma once

#include "slicemorph/image.h"

#include <functional>
#include <vector>

namespace slicemorph {

/// An image resampled at the voxels of another lattice, trilinear; outside the image its lowest value. Exact
/// where voxels coincide.
Image resampledTo(const Image& image, const ImageLattice& on);

/// An image at the voxels of another lattice, row by row: as resampledTo, but not rounded.
class ResampledRows {
 public:
  /// The image must outlive this.
  ResampledRows(const Image& image, const ImageLattice& on);
  /// Writes the values at the voxels (0 ..., j, k) of the lattice.
  void read(int j, int k, double* row) const { read_(j, k, row); }

 private:
  std::function<void(int, int, double*)> read_;
};

/// A label map at the voxels of another lattice: the nearest voxel's label, 0 outside the map.
Image nearestTo(const Image& labels, const ImageLattice& on);

/// Slices of a lattice, from `from` up to before `to`.
struct SliceRange {
  int from, to;
};
/// All slices of a lattice, in parts of about a million voxels.
std::vector<SliceRange> sliceRanges(const ImageLattice& lattice);

/// An image at any positions: at the voxels of `on` in some slices, i fastest, the values at the world points that
/// `positions` gives for them. `nearest`: the nearest voxel's value, 0 outside, as of label maps; else trilinear,
/// outside the lowest value.
Image sampledAt(const Image& image, const ImageLattice& on,
                const std::function<std::vector<Vec3d>(const SliceRange&)>& positions, bool nearest);

}  // namespace slicemorph

#include "tools/job/compare_maps.h"

#include "engine/measure/label_measures.h"
#include "engine/volume/image_grid.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/same_image.h"
#include "tools/job/memory_need.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Voxels that lie nearer to each other than this part of one are the same: more than floats of 32 bits leave of an
/// affine transform over a thousand voxels.
constexpr double kSameVoxel = 0.01;

/// The lattice with as many more voxels as the other one's box needs.
ImageLattice extended(const ImageLattice& lattice, const ImageLattice& other) {
  const WorldToVoxel voxel(lattice);
  openvdb::Coord low(0), high = lattice.size - openvdb::Coord(1);
  for (int c = 0; c < 8; ++c) {
    Vec3d corner;
    for (int d = 0; d < 3; ++d) corner[d] = c >> d & 1 ? other.size[d] - 0.5 : -0.5;
    const Vec3d at = voxel(other.toWorld(corner));
    for (int d = 0; d < 3; ++d) {
      low[d] = std::min(low[d], int(std::floor(at[d] + kSameVoxel)));
      high[d] = std::max(high[d], int(std::ceil(at[d] - kSameVoxel)));
    }
  }
  ImageLattice result = lattice;
  result.size = high - low + openvdb::Coord(1);
  result.origin = lattice.toWorld(low.asVec3d());
  return result;
}

}  // namespace

MapComparison compareMaps(const Image& a, const Image& b, const MemoryLimit& memory,
                          const std::string& name) {
  labelsOf(a), labelsOf(b);  // says what is no label
  // Two masks, outer voxels and a field of floats, both maps as labels; and both again on other voxels.
  constexpr double kBytes = 16, kBytesOfBoth = 12;
  if (sameLattice(a.lattice, b.lattice, kSameVoxel)) {
    require(memory, name, needOfImage(a.lattice, kBytes));
    return {compareLabels(a, b), {}};
  }
  const ImageLattice on = extended(a.lattice, b.lattice);
  require(memory, name, needOfImage(on, kBytes + kBytesOfBoth));
  MapComparison result{compareLabels(nearestTo(a, on), nearestTo(b, on)), {}};
  for (const LabelMeasures& m : measureLabels(b)) {
    auto at = std::find_if(result.labels.begin(), result.labels.end(),
                           [&](const LabelComparison& c) { return c.label >= m.label; });
    if (at == result.labels.end() || at->label != m.label) {  // too small for A's voxels
      at = result.labels.insert(at, LabelComparison());
      at->label = m.label;
    }
    at->voxels[1] = m.voxels, at->volume[1] = m.volume, at->centroid[1] = m.centroid;
  }
  result.notes.emplace_back(
      "compare.other-voxels", Severity::kNote, "",
      "B has other voxels than A: it was put on A's, the nearest voxel's label each; overlaps and "
      "distances are as exact as these");
  return result;
}

}  // namespace slicemorph

#include "tools/job/image_lattice.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/image_shape.h"
#include "io/image/label_values.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/output.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Voxels added around a shape that reaches beyond the first image.
constexpr int kMargin = 2;

}  // namespace

bool isLabelMap(const Image& image, ImageKind kind) {
  return kind == ImageKind::kLabels || (kind == ImageKind::kAuto && looksLikeLabels(image));
}

void takeLabels(ImageFile& file, ImageKind kind) {
  if (kind != ImageKind::kGrey) takeLabels(file.image, kind == ImageKind::kLabels, file.notes);
}

ImageLattice cubicLattice(const ImageLattice& lattice, const LoadOptions& options) {
  const Vec3d spacing = lattice.spacing();
  double longest = 0;
  for (int d = 0; d < 3; ++d) longest = std::max(longest, lattice.size[d] * spacing[d]);
  const double edge = options.voxelSize > 0 ? options.voxelSize : longest / options.resolution;
  ImageLattice cubic = lattice;
  for (int d = 0; d < 3; ++d) {
    const Vec3d direction = lattice.step[d] / spacing[d];
    // The box, whose faces are half a voxel beyond the outermost voxel centres, keeps its centre, and its
    // size to half a new voxel.
    cubic.size[d] = std::max(1, int(std::lround(lattice.size[d] * spacing[d] / edge)));
    cubic.step[d] = direction * edge;
    cubic.origin += direction * (0.5 * (lattice.size[d] * spacing[d] - cubic.size[d] * edge) + 0.5 * edge -
                                 0.5 * spacing[d]);
  }
  return cubic;
}

ImageVoxels voxelsLike(const std::string& path, const ImageOptions& options) {
  ImageFile like = readImage(path, options);
  return {like.image.lattice, std::move(like.header.forms)};
}

LatticeChoice latticeAround(const std::vector<LoadedObject>& objects) {
  const ImageLattice& first = objects[0].image->lattice;
  const WorldToVoxel voxel(first);
  openvdb::Coord low(0), high = first.size - openvdb::Coord(1);
  for (size_t k = 1; k < objects.size(); ++k) {
    const FloatGrid& shape = *objects[k].object.levelSet;
    // The box of the surface without the narrow band around it.
    openvdb::CoordBBox band = shape.evalActiveVoxelBoundingBox();
    band.expand(-int(kHalfWidth));
    const openvdb::BBoxd box = shape.transform().indexToWorld(band);
    Vec3d least(1e30), most(-1e30);
    for (int c = 0; c < 8; ++c) {
      const Vec3d corner(c & 1 ? box.max()[0] : box.min()[0], c & 2 ? box.max()[1] : box.min()[1],
                         c & 4 ? box.max()[2] : box.min()[2]);
      const Vec3d v = voxel(corner);
      least = openvdb::math::minComponent(least, v), most = openvdb::math::maxComponent(most, v);
    }
    for (int d = 0; d < 3; ++d) {
      if (least[d] < -1) low[d] = std::min(low[d], int(std::floor(least[d])) - kMargin);
      if (most[d] > first.size[d]) high[d] = std::max(high[d], int(std::ceil(most[d])) + kMargin);
    }
  }
  ImageLattice lattice = first;
  lattice.size = high - low + openvdb::Coord(1);
  lattice.origin = first.toWorld(low.asVec3d());
  if (lattice.size == first.size) return {lattice, {}};
  const Note grown(
      "image.lattice-grown", Severity::kNote, "",
      "the shapes reach beyond the first image: the result has " + std::to_string(lattice.size[0]) + " x " +
          std::to_string(lattice.size[1]) + " x " + std::to_string(lattice.size[2]) +
          " voxels, the first image's own and more around them (--like keeps an image's voxels)");
  return {lattice, {grown}};
}

void checkOutput(const std::string& path) {
  if (isImageOutput(path))
    checkOutputPath(path);
  else
    checkSurfaceOutput(path);
}

}  // namespace slicemorph

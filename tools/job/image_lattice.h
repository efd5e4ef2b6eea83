#pragma once

#include "slicemorph/io/input.h"
#include "slicemorph/note.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// Whether an image is taken as a map of labels.
bool isLabelMap(const Image& image, ImageKind kind);

/// Rounds labels that are stored as floating point, where the image is not read as grey; see takeLabels().
void takeLabels(ImageFile& file, ImageKind kind);

/// A lattice of cubic voxels over the same box: of the given voxel size, or with `resolution` voxels along
/// the longest side.
ImageLattice cubicLattice(const ImageLattice& lattice, const LoadOptions& options);

/// The voxels of another image (--like), and the codes of space that belong to them.
struct ImageVoxels {
  ImageLattice lattice;
  std::optional<NiftiForms> forms;
};
ImageVoxels voxelsLike(const std::string& path, const ImageOptions& options);

/// The voxels of in-between images: those of the first image, extended as far as the other objects' shapes
/// need; if so, the notes say it.
struct LatticeChoice {
  ImageLattice lattice;
  Notes notes;
};
LatticeChoice latticeAround(const std::vector<LoadedObject>& objects);

/// Throws InputError where no surface or image can be written with the path's extension, IoError where its
/// folder is missing or cannot be written to.
void checkOutput(const std::string& path);

}  // namespace slicemorph

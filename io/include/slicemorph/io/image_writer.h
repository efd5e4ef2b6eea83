#pragma once

#include "slicemorph/io/image_header.h"

#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// Whether an output is an image by its extension: .nii .nii.gz .nrrd .mha.
bool isImageOutput(const std::string& path);

/// Writes an image whole or not at all, with its own value type, compressed unless .nii; LPS is converted to
/// the format's axes. NIfTI gets both transforms of `header` where the voxels are those that they place; else an sform,
/// and a qform where the axes are at right angles, of the space that they are of. The same bytes for
/// any thread count. Throws InputError for another extension, and IoError.
void writeImage(const std::string& path, const Image& image, const ImageHeader& header = {});

class VoxelFile;

/// Writes an image slice by slice, the same bytes as writeImage(), or several volumes of one lattice one after the
/// other: a fourth axis of times in the file.
class ImageSliceWriter {
 public:
  /// `like`: values of the type that follows. Several volumes follow each other slice by slice. Throws as
  /// writeImage().
  ImageSliceWriter(const std::string& path, const ImageLattice& lattice, const ImageValues& like,
                   int volumes = 1, const ImageHeader& header = {});
  ~ImageSliceWriter();
  /// The next slices along k. Throws IoError, and std::logic_error for another type or too many.
  void add(const ImageValues& slices);
  /// After the last one; without it there is no file. Throws IoError, and std::logic_error if slices are missing.
  void commit();

 private:
  std::unique_ptr<VoxelFile> file_;
  size_t type_ = 0;  ///< of the values: index in ImageValues
  size_t left_ = 0;  ///< voxels that are missing
};

/// A vector at every voxel, as of a displacement field.
struct VectorImage {
  ImageLattice lattice;
  std::vector<openvdb::Vec3s> vectors;  ///< lattice.count() of them; world units along LPS
  std::string meaning;                  ///< one line for the file's header
};

/// Writes vectors as 32-bit floats, otherwise as writeImage(). The three numbers of a vector stay in LPS in every
/// format, also in NIfTI (intent "vector"), as ITK, ANTs and 3D Slicer have it. Throws InputError for another extension,
/// and IoError.
void writeVectors(const std::string& path, const VectorImage& image);

}  // namespace slicemorph

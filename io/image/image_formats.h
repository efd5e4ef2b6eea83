#pragma once

#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"
#include "slicemorph/io/image_writer.h"

#include <optional>
#include <string>
#include <vector>

/// Functions of image formats, for the table of formats (io/formats.cpp).
namespace slicemorph {

/// A .dcm file, or a folder.
bool isDicomImage(const std::string& path);
/// A .tif, or a numbered sequence of .png or .exr.
bool isImageStack(const std::string& path);

/// As readImage.
ImageFile readNiftiImage(const InputSpec& input, const ImageOptions& options);
ImageFile readNrrdImage(const InputSpec& input, const ImageOptions& options);
ImageFile readMetaImageFile(const InputSpec& input, const ImageOptions& options);
ImageFile readDicomImage(const InputSpec& input, const ImageOptions& options);
ImageFile readStackImage(const InputSpec& input, const ImageOptions& options);
/// As listImages.
std::vector<ImageFile> listDicomImages(const InputSpec& input, const ImageOptions& options);
std::vector<ImageFile> listStackImages(const InputSpec& input, const ImageOptions& options);

/// As openImageSlices.
std::optional<ImageSlices> openNiftiSlices(const InputSpec& input, const ImageOptions& options);
std::optional<ImageSlices> openNrrdSlices(const InputSpec& input, const ImageOptions& options);
std::optional<ImageSlices> openMetaImageSlices(const InputSpec& input, const ImageOptions& options);
std::optional<ImageSlices> openStackSlices(const InputSpec& input, const ImageOptions& options);

/// What a file of voxels holds: numbers or vectors on a lattice.
struct Voxels {
  const ImageLattice& lattice;
  size_t type;           ///< of the numbers: index in ImageValues
  size_t bytes;          ///< of a number
  bool vectors = false;  ///< three numbers a voxel
  std::string meaning;   ///< one line; empty: nothing to say
  int volumes = 1;       ///< of numbers, one after the other
};
enum class Packing { kNone, kGzip, kZlib };
/// What stands before the values, and how these follow.
struct VoxelHead {
  std::string bytes;
  Packing packing = Packing::kNone;  ///< of the values
  bool packed = false;               ///< the head too is
  bool interleaved = true;           ///< the three numbers of a vector stand together
};
VoxelHead niftiHead(const std::string& path, const Voxels& voxels);
VoxelHead nrrdHead(const std::string& path, const Voxels& voxels);
VoxelHead metaImageHead(const std::string& path, const Voxels& voxels);

}  // namespace slicemorph

#pragma once

#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"
#include "slicemorph/io/image_writer.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Functions of image formats, for the table of formats (io/formats.cpp).
namespace slicemorph {

/// A folder, a .dcm or .ima file, or one of any name that begins as DICOM files do.
bool isDicomImage(const std::string& path);
/// A .tif, or a numbered sequence of .png or .exr.
bool isImageStack(const std::string& path);

/// As readImage.
ImageFile readNiftiImage(const InputSpec& input, const ImageOptions& options);
ImageFile readNrrdImage(const InputSpec& input, const ImageOptions& options);
ImageFile readMetaImageFile(const InputSpec& input, const ImageOptions& options);
ImageFile readDicomImage(const InputSpec& input, const ImageOptions& options);
ImageFile readStackImage(const InputSpec& input, const ImageOptions& options);
/// As ImageLister.
void listDicomImages(const InputSpec& input, const ImageOptions& options, double mostVoxels,
                     const std::function<void(ImageFile)>& visit);
void listStackImages(const InputSpec& input, const ImageOptions& options, double mostVoxels,
                     const std::function<void(ImageFile)>& visit);
/// The same of any input that is an image.
void visitImages(const InputSpec& input, const ImageOptions& options, double mostVoxels,
                 const std::function<void(ImageFile)>& visit);
/// Code of the note on an image without values because it is refused.
constexpr const char* kImageRefused = "image.refused";

/// Code of the note on an image without values because only its headers were read.
constexpr const char* kHeaderOnly = "image.header-only";

/// Code of the note by which a reader says so.
constexpr const char* kLabelsStated = "image.labels-stated";
/// Whether a file itself says that its values are labels, as segmentations do; a note's code tells it.
bool isStatedLabels(const ImageFile& file);

/// Code of the warnings that tell how voxels were placed because --force insisted.
constexpr const char* kGeometryForced = "image.geometry-forced";

/// Code of the detail that the time between volumes is taken from a scan's repetition time.
constexpr const char* kTimeByRepetition = "image.time-by-repetition";

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
  int volumes = 1;
  ImageHeader header;
};
enum class Packing { kNone, kGzip, kZlib };
/// What stands before the values, and how these follow.
struct VoxelHead {
  std::string bytes;
  Packing packing = Packing::kNone;  ///< of the values
  bool packed = false;               ///< the head too is
  bool interleaved = true;           ///< the three numbers of a vector stand together
  /// Where the bytes of the packed values are told, in kSizeDigits letters, if the head does.
  std::optional<size_t> sizeAt = std::nullopt;
  static constexpr size_t kSizeDigits = 20;
};
VoxelHead niftiHead(const std::string& path, const Voxels& voxels);
VoxelHead nrrdHead(const std::string& path, const Voxels& voxels);
/// Labels of several layers; `wide`: of 16 bits, else 8. `keys`: lines of key and value.
VoxelHead nrrdLabelsHead(const ImageLattice& lattice, int layers, bool wide, const std::string& keys);
VoxelHead metaImageHead(const std::string& path, const Voxels& voxels);
/// Writes a head and the values behind it, whole or not at all. Throws IoError.
void writeVoxels(const std::string& path, const VoxelHead& head, std::string_view values);

}  // namespace slicemorph

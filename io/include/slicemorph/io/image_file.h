#pragma once

#include "slicemorph/image.h"
#include "slicemorph/io/image_header.h"
#include "slicemorph/io/input_spec.h"
#include "slicemorph/io/memory.h"
#include "slicemorph/note.h"

#include <string>
#include <vector>

namespace slicemorph {

/// An image as read from a file: world space is LPS millimetres.
struct ImageFile {
  Image image;
  std::string name;    ///< as an input selects it
  std::string format;  ///< "NIfTI", "NRRD", "MetaImage", "DICOM series", "image stack"
  std::string about;   ///< what the file says of itself, for example modality and series; may be empty
  int volumes = 1;     ///< the file holds: times of a 4D file, or components of a voxel
  ImageHeader header;
  Notes notes;  ///< what was repaired, chosen or assumed, one sentence each
};

struct ImageOptions {
  Vec3d spacing{
      0, 0,
      0};  ///< millimetres between voxels along i, j, k, for image stacks, which hold none; zero: none given
  bool force =
      false;      ///< where voxels lie is taken as well as it can be told, with warnings, instead of refused
  char up = 'y';  ///< the axis that points up in the job, to which one in braces behind a name is turned
  MemoryLimit memory;  ///< what does not fit is refused before its values are read
};

/// Reads one image: .nii .nii.gz .nrrd .nhdr .mha .mhd .dcm, a folder of DICOM slices, an image stack, a .tif
/// of several pages. Throws, naming the file, IoError where it is missing, damaged or truncated, and
/// InputError for a wrong or missing choice of volume, series or spacing; MemoryError where its values would not fit.
ImageFile readImage(const InputSpec& input, const ImageOptions& options = {});
ImageFile readImage(const std::string& text, const ImageOptions& options = {});

/// For listings: every series of a DICOM folder where none is selected, else one image. A stack without
/// spacing has no values.
std::vector<ImageFile> listImages(const InputSpec& input, const ImageOptions& options = {});

}  // namespace slicemorph

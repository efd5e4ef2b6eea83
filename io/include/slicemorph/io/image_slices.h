#pragma once

#include "slicemorph/io/image_file.h"

#include <functional>
#include <optional>
#include <string>

namespace slicemorph {

/// An image that is read slice by slice along k, so that the whole need not be in memory.
struct ImageSlices {
  ImageFile file;    ///< its values: none, but of the type of those that follow
  size_t bytes = 0;  ///< that each voxel takes while readImage() reads it
  /// The values of the next slice, for as many as there are: those that readImage() reads. Throws IoError.
  std::function<ImageValues()> next;
};

/// Opens .nii .nii.gz .nrrd .mha .mhd, picture stacks; nothing where a file cannot be read slice by slice: other
/// formats, voxels of several volumes or components, values that need rescaling, headers apart from their data in NRRD.
/// Throws as readImage().
std::optional<ImageSlices> openImageSlices(const std::string& text, const ImageOptions& options = {});

}  // namespace slicemorph

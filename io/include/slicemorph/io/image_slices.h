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

/// Opens NIfTI, NRRD, MetaImage, picture stacks, of which nothing but the header is read before next(); nothing where
/// a file cannot be read slice by slice: other formats, colours, numbers as text, values that need rescaling. Throws as
/// readImage().
std::optional<ImageSlices> openImageSlices(const InputSpec& input, const ImageOptions& options = {});
std::optional<ImageSlices> openImageSlices(const std::string& text, const ImageOptions& options = {});

}  // namespace slicemorph

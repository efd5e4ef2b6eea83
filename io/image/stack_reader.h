#pragma once

#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"

namespace slicemorph {

/// Reads a numbered stack of pictures (`name.####.tif|png|exr`, in the order of their numbers) or one .tif of
/// several pages. Rows run along +x, columns along +y (a picture's first row has the smallest y, as scanners
/// store it), pictures along +z in the order of the files. Colours become luminance (ITU-R BT.709), with a
/// note. EXR pictures are placed by their data windows within their display windows. A .tif may tell its spacing, and
/// that its pages are channels or times, of which one is read (ImageJ, OME). `placed` false: where no spacing is known,
/// only the description. Throws InputError without a spacing, IoError for pictures that are missing, unreadable or of
/// different sizes.
ImageFile readStack(const InputSpec& input, const ImageOptions& options, bool placed = true);

/// The same slice by slice, as openImageSlices.
std::optional<ImageSlices> openStack(const InputSpec& input, const ImageOptions& options);

}  // namespace slicemorph

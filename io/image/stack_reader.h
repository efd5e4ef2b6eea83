#pragma once

#include "slicemorph/io/image_file.h"

namespace slicemorph {

/// Reads a numbered stack of pictures (`name.####.tif|png|exr`, in the order of their numbers) or one .tif of
/// several pages. Rows run along +x, columns along +y (the first row of a picture is that of the smallest y,
/// as scanners store it), pictures along +z; the file order is the order of space. Colours count as their
/// luminance (Rec. 709), with a note. Throws InputError without a spacing, IoError for pictures that are
/// missing, unreadable or of different size.
ImageFile readStack(const InputSpec& input, const ImageOptions& options, bool values = true);

}  // namespace slicemorph

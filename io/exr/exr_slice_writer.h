#pragma once

#include "engine/sections/section_plane.h"
#include "io/exr/exr_slice.h"
#include "slicemorph/progress.h"

#include <functional>
#include <optional>

namespace slicemorph {

struct SliceExrOptions {
  bool halfFloat = false;           ///< 16-bit channels; whole numbers and flags keep 32
  std::string compression = "zip";  ///< of exrCompressions()
  int tile = 0;                     ///< edge of a tile, pixels; 0: scan lines
  std::string units = "world units";
  std::optional<double> t;
  std::optional<int> frame;
  std::optional<double> framesPerSecond;
};

/// none rle zips zip piz pxr24 b44 b44a dwaa dwab; from pxr24 on they lose precision.
const std::vector<std::string>& exrCompressions();

/// Samples grids on plane `n` of a set and writes them as io/exr/exr_slice.h says. Thread-safe. The file appears
/// whole or not at all. Throws IoError; InputError for an unknown compression, and for a value that half
/// floats cannot hold.
void writeSliceExr(const std::string& path, const std::vector<SliceGrid>& grids,
                   const std::vector<SectionPlane>& planes, size_t n, const SliceExrOptions& options = {});

/// All slices, each in a file of its own; uses all threads. Throws as above, and Cancelled.
void writeSliceFiles(const std::function<std::string(size_t)>& path, const std::vector<SliceGrid>& grids,
                     const std::vector<SectionPlane>& planes, const SliceExrOptions& options,
                     Progress& progress);

/// All slices as parts of one file, `slice.0001` and so on; uses all threads. Throws as above, and Cancelled.
void writeSlicesExr(const std::string& path, const std::vector<SliceGrid>& grids,
                    const std::vector<SectionPlane>& planes, const SliceExrOptions& options,
                    Progress& progress);

}  // namespace slicemorph

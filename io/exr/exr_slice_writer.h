#pragma once

#include "engine/sections/section_plane.h"
#include "io/exr/exr_slice.h"
#include "slicemorph/progress.h"

#include <functional>
#include <optional>

namespace slicemorph {

struct SliceExrOptions {
  bool halfFloat = false;           ///< 16-bit channels; integers and flags keep 32 bits
  std::string compression = "zip";  ///< of exrCompressions()
  int tile = 0;                     ///< edge of a tile, pixels; 0: scan lines
  std::string units = "world units";
  std::optional<double> t;
  std::optional<int> frame;
  std::optional<double> framesPerSecond;
};

/// none rle zips zip piz pxr24 b44 b44a dwaa dwab; pxr24 and those after it lose precision.
const std::vector<std::string>& exrCompressions();

/// Samples grids on plane `n` of a set and writes them in the layout of io/exr/exr_slice.h. Thread-safe. The
/// file appears whole or not at all. Throws IoError; InputError for an unknown compression and for a value
/// that half floats cannot hold.
void writeSliceExr(const std::string& path, const std::vector<SliceGrid>& grids,
                   const std::vector<SectionPlane>& planes, size_t n, const SliceExrOptions& options = {});

/// Writes all slices, each in a file of its own, on all threads. Throws as writeSliceExr, and Cancelled.
void writeSliceFiles(const std::function<std::string(size_t)>& path, const std::vector<SliceGrid>& grids,
                     const std::vector<SectionPlane>& planes, const SliceExrOptions& options,
                     Progress& progress);

/// Writes all slices as parts of one file, `slice.0001` and so on, on all threads. Throws as
/// writeSliceExr, and Cancelled.
void writeSlicesExr(const std::string& path, const std::vector<SliceGrid>& grids,
                    const std::vector<SectionPlane>& planes, const SliceExrOptions& options,
                    Progress& progress);

}  // namespace slicemorph

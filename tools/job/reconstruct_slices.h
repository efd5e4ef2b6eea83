#pragma once

#include <optional>
#include <string>

namespace slicemorph {

struct SlicesJob {
  std::string input, output;
  std::optional<std::string> grids;  ///< names separated by commas; none: all
  double voxelSize = 0;              ///< world units; 0: a pixel
  bool quiet = false;
};

/// `slicemorph reconstruct` of EXR slices: all grids into a `.vdb`, the one of a surface into a mesh, the one
/// of values into an image. Throws what is to be reported.
void reconstructSlices(const SlicesJob& job);

}  // namespace slicemorph

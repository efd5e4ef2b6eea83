#pragma once

#include "io/usd/usda_text.h"

#include <string>
#include <vector>

namespace slicemorph {

/// A frame of a sequence of VDB files.
struct UsdaFrame {
  int number;        ///< its time code
  std::string path;  ///< of its file, in the stage's folder
};

/// Writes a `.usda` stage that shows a sequence of VDB files beside it: one Volume, and beneath it for each grid an
/// OpenVDBAsset with the files as time samples, the grid's name, its index among those of its name, class, type and
/// kind of vector, which are read from the files that are there, as are the Volume's extents. A grid that a file
/// lacks has no value at that time. Files that are not there (yet) are named all the same, without extents; so
/// several processes that make some of the files each may all write the stage, and the last one's is complete. The
/// file appears whole or not at all. Throws IoError.
void writeUsdaVolume(const std::string& path, const std::vector<UsdaFrame>& frames, const UsdaStage& stage);

}  // namespace slicemorph

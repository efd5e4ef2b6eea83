#include "engine/volume/fog.h"

#include <openvdb/tools/LevelSetUtil.h>

namespace slicemorph {

FloatGrid::Ptr fogOf(const FloatGrid& levelSet) {
  FloatGrid::Ptr fog = levelSet.deepCopy();
  openvdb::tools::sdfToFogVolume(*fog);
  return fog;
}

}  // namespace slicemorph

#include "slicemorph/grids.h"

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {

SLICEMORPH_GRID_CODE(, BoolTree)
SLICEMORPH_GRID_CODE(, MaskTree)
SLICEMORPH_GRID_CODE(, Vec3STree)
SLICEMORPH_GRID_CODE(, Vec3DTree)
SLICEMORPH_GRID_CODE(, Vec3ITree)

}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb

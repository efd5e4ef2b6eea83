#include "slicemorph/grids.h"

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {

SLICEMORPH_GRID_CODE(, FloatTree)
SLICEMORPH_GRID_CODE(, DoubleTree)
SLICEMORPH_GRID_CODE(, Int32Tree)
SLICEMORPH_GRID_CODE(, Int64Tree)

}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb

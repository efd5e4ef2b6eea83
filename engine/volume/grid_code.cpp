#include "slicemorph/grids.h"

/// Code of OpenVDB's grids that no source makes for itself (see slicemorph/grids.h) and that Debian's library does not hold.
#ifdef SLICEMORPH_SHARES_GRID_CODE
#define SLICEMORPH_GRID_CODE(TREE)                                                                        \
  template void TREE::RootNodeType::addLeaf(TREE::LeafNodeType*);                                         \
  template void TREE::RootNodeType::addTile(Index, const Coord&, const TREE::ValueType&, bool);           \
  template void TREE::RootNodeType::getNodeLog2Dims(std::vector<Index>&);                                 \
  template TREE::RootNodeType::MapType::const_iterator TREE::RootNodeType::findCoord(const Coord&) const; \
  template void TREE::RootNodeType::ChildNodeType::ChildNodeType::getNodeLog2Dims(std::vector<Index>&);   \
  template void TREE::RootNodeType::ChildNodeType::getNodeLog2Dims(std::vector<Index>&);                  \
  template void TREE::attachAccessor(tree::ValueAccessorBase<TREE, true>&) const;                         \
  template void TREE::attachAccessor(tree::ValueAccessorBase<const TREE, true>&) const;

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {

SLICEMORPH_GRID_CODE(FloatTree)
SLICEMORPH_GRID_CODE(DoubleTree)
SLICEMORPH_GRID_CODE(BoolTree)
SLICEMORPH_GRID_CODE(MaskTree)
SLICEMORPH_GRID_CODE(Int32Tree)
SLICEMORPH_GRID_CODE(Int64Tree)
SLICEMORPH_GRID_CODE(Vec3STree)
SLICEMORPH_GRID_CODE(Vec3DTree)
SLICEMORPH_GRID_CODE(Vec3ITree)

}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb
#endif

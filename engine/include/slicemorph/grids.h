#pragma once

#include <openvdb/openvdb.h>

/// Explicit instantiations of OpenVDB's grids. OpenVDB is header-only: every source that creates a grid
/// compiles hundreds of functions for reading, writing, merging and the like, about ten seconds of work per
/// type and source. These declarations leave that to engine/volume/grid_code_*.cpp, once per type.
#define SLICEMORPH_GRID_CODE(EXTERN, TREE)                                                       \
  EXTERN template class Grid<TREE>;                                                              \
  EXTERN template class tree::Tree<TREE::RootNodeType>;                                          \
  EXTERN template class tree::InternalNode<TREE::RootNodeType::ChildNodeType::ChildNodeType, 5>; \
  EXTERN template class tree::InternalNode<TREE::LeafNodeType, 4>;

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {

SLICEMORPH_GRID_CODE(extern, FloatTree)
SLICEMORPH_GRID_CODE(extern, DoubleTree)
SLICEMORPH_GRID_CODE(extern, BoolTree)
SLICEMORPH_GRID_CODE(extern, MaskTree)
SLICEMORPH_GRID_CODE(extern, Int32Tree)
SLICEMORPH_GRID_CODE(extern, Int64Tree)
SLICEMORPH_GRID_CODE(extern, Vec3STree)
SLICEMORPH_GRID_CODE(extern, Vec3DTree)
SLICEMORPH_GRID_CODE(extern, Vec3ITree)

}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb

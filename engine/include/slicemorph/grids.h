#pragma once

#include <openvdb/openvdb.h>

/// OpenVDB's grids, without making their code anew in every source. Debian's OpenVDB 10 holds the code of nearly all members of
/// its standard grids, as it registers them, but its headers do not say so: whoever creates a grid compiles hundreds of
/// functions for reading, writing, merging and the like, some ten seconds of work for each type and source. What the library
/// does not hold is made once in engine/volume/grid_code.cpp. With another version, or with SLICEMORPH_OWN_GRID_CODE, all is
/// compiled wherever it is used.
#if OPENVDB_LIBRARY_MAJOR_VERSION_NUMBER == 10 && !defined(SLICEMORPH_OWN_GRID_CODE)
#define SLICEMORPH_SHARES_GRID_CODE
#endif

#ifdef SLICEMORPH_SHARES_GRID_CODE
#define SLICEMORPH_EXTERN_GRID(TREE)                                                             \
  extern template class Grid<TREE>;                                                              \
  extern template class tree::Tree<TREE::RootNodeType>;                                          \
  extern template class tree::RootNode<TREE::RootNodeType::ChildNodeType>;                       \
  extern template class tree::InternalNode<TREE::RootNodeType::ChildNodeType::ChildNodeType, 5>; \
  extern template class tree::InternalNode<TREE::LeafNodeType, 4>;                               \
  extern template class tree::LeafNode<TREE::BuildType, 3>;

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {

SLICEMORPH_EXTERN_GRID(FloatTree)
SLICEMORPH_EXTERN_GRID(DoubleTree)
SLICEMORPH_EXTERN_GRID(BoolTree)
SLICEMORPH_EXTERN_GRID(MaskTree)
SLICEMORPH_EXTERN_GRID(Int32Tree)
SLICEMORPH_EXTERN_GRID(Int64Tree)
SLICEMORPH_EXTERN_GRID(Vec3STree)
SLICEMORPH_EXTERN_GRID(Vec3DTree)
SLICEMORPH_EXTERN_GRID(Vec3ITree)

}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb

#undef SLICEMORPH_EXTERN_GRID
#endif

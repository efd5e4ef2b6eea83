#include "io/vdb/grid_box.h"

namespace slicemorph {

openvdb::CoordBBox activeBoxIn(const VdbFile& file, size_t index, const openvdb::GridBase& header) {
  const auto low = header.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto high = header.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  if (low && high) return {openvdb::Coord(low->value()), openvdb::Coord(high->value())};
  return file.readDelayed(index)->evalActiveVoxelBoundingBox();
}

}  // namespace slicemorph

#pragma once

#include "slicemorph/image.h"
#include "slicemorph/io/structure_file.h"

#include <openvdb/openvdb.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace slicemorph {

/// What StructureShape::onPlane is of one label of a map: half minus its share, linear between voxels. On the map's own
/// slices it is -0.5 at the label's pixels and 0.5 at the others. `box`: the label's voxels.
std::function<std::vector<float>(const ImagePlane&)> labelOnPlane(std::shared_ptr<const Image> map,
                                                                  std::int64_t label,
                                                                  const openvdb::CoordBBox& box);
/// The same of a level set: its distances, linear between voxels.
std::function<std::vector<float>(const ImagePlane&)> surfaceOnPlane(FloatGrid::ConstPtr grid);

/// The world box of a grid's active voxels.
openvdb::BBoxd boxOfGrid(const FloatGrid& grid);

}  // namespace slicemorph

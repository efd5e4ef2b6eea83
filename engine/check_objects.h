#pragma once

#include "engine/blend/local_weights.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// Throws InputError if there are no objects or options are out of range, and GeometryError for level sets
/// that are empty or violate the conventions (conventions.h).
void checkObjects(const std::vector<Object>& objects, const MorphOptions& options);

/// Throws GeometryError if a grid violates the conventions for level sets (conventions.h): other grid class,
/// voxels that are not cubes parallel to the axes, other half width of the band, or values that are not
/// finite. `name`: for messages.
void checkLevelSet(const FloatGrid& grid, const std::string& name);

/// Throws InputError if a region contains nothing of the shape on which it is defined.
/// `names`: of the shapes.
void checkRegions(const std::vector<Region>& regions, const RegionShares& shares, const Fields& fields,
                  const std::vector<std::string>& names);

}  // namespace slicemorph

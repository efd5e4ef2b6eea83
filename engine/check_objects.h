#pragma once

#include "engine/blend/local_weights.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// Throws InputError for no object at all and for options out of range; GeometryError for level sets that are
/// empty or against the conventions. The messages name the object or option, its value and what would be
/// right.
void checkObjects(const std::vector<Object>& objects, const MorphOptions& options);

/// Throws GeometryError where a level set is against the conventions (conventions.h): of another class, on
/// voxels that are not uniform or not parallel to the axes, with a band of another width, or with values that
/// are no numbers. `name`: for messages.
void checkLevelSet(const FloatGrid& grid, const std::string& name);

/// Throws InputError where a region holds nothing of the shape on which it is drawn. `names`: of the shapes.
void checkRegions(const std::vector<Region>& regions, const RegionShares& shares, const Fields& fields,
                  const std::vector<std::string>& names);

}  // namespace slicemorph

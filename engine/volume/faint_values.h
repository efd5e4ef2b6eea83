#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// The smallest active value that is not 0, by its magnitude; infinite where there is none, and in grids that are not of
/// floats or doubles.
double faintestValue(const openvdb::GridBase& grid);

/// Takes active values of a magnitude below `least`, and those that are 0, out of a grid of floats or doubles: they
/// become inactive and get its background's value.
void dropFainter(openvdb::GridBase& grid, double least);

}  // namespace slicemorph

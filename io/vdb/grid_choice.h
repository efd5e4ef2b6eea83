#pragma once

#include "slicemorph/io/input_spec.h"
#include "slicemorph/io/vdb_reader.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// True for grids of floats or doubles; only these can have a surface.
bool isScalar(const openvdb::GridBase& grid);

/// Index of the grid that the input names. Throws InputError, which lists the file's grids, where it is
/// missing or not scalar.
size_t findGrid(const VdbFile& file, const InputSpec& input);

/// Indices of the scalar grids in the order in which they are tried where none is named: those of class level
/// set, then `density`, then level sets that are dense by the file's statistics (domains of a simulation),
/// unknown classes, other fog volumes. Throws InputError, which lists the file's grids, where there is none.
std::vector<size_t> gridsToTry(const VdbFile& file, const std::string& path);

/// A float grid as it is, a double grid converted; null for any other.
FloatGrid::ConstPtr asFloatGrid(const openvdb::GridBase::Ptr& grid);

/// Index of the vector grid that holds colours, by its name (isColorName): "Cd" before "color" before others.
std::optional<size_t> findColors(const VdbFile& file);

/// A grid of float vectors as it is, one of doubles converted; null for any other.
openvdb::Vec3SGrid::ConstPtr asColorGrid(const openvdb::GridBase::Ptr& grid);

}  // namespace slicemorph

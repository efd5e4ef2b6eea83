#pragma once

#include "slicemorph/io/input.h"
#include "slicemorph/note.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// Grids of one name, one per input, that are morphed into each other.
struct GridSet {
  std::string name;
  std::vector<std::optional<size_t>> index;  ///< per input: in its file; none where it has no such grid
};

/// All that the files of several inputs hold.
struct GridSets {
  std::vector<GridSet> sets;  ///< in the order of the first input's file, then of the others'
  Notes notes;                ///< what cannot be morphed and why, one sentence each
};

/// Pairs the grids of the inputs by name, the second of several of one name with the second. Left out, with a
/// note: grids of types that cannot be carried, and those whose type differs from the first input's of that
/// name. `onlyNamed`: of inputs whose grid was named (`file.vdb:grid`) that one alone.
GridSets pairGrids(const std::vector<LoadedObject>& inputs, bool onlyNamed = false);

/// The set that the inputs' shapes make: their own grids whatever their names, named after the first.
GridSet shapeSet(const std::vector<LoadedObject>& inputs);

/// A set's grids, one per input, null where it has none. Values are read when they are looked at. Throws
/// IoError.
std::vector<openvdb::GridBase::ConstPtr> readGrids(const GridSet& set,
                                                   const std::vector<LoadedObject>& inputs);

}  // namespace slicemorph

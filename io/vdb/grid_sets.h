#pragma once

#include "slicemorph/io/input.h"
#include "slicemorph/note.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// Grids of one name, one per input, that are morphed into each other.
struct GridSet {
  std::string name;
  std::vector<std::optional<size_t>> index;  ///< per input: index in its file; none where it has no such grid
  /// Of a vector field that files hold as three grids of numbers, as `vel.x vel.y vel.z`, whose common name is `name`:
  /// the names of these, and per input the indices of the second and the third; else empty.
  std::vector<std::string> parts = {};
  std::vector<std::array<size_t, 2>> others = {};
};

/// The grids of several inputs' files, paired.
struct GridSets {
  std::vector<GridSet> sets;  ///< in the order of the first input's file, then of the others'
  Notes notes;                ///< what cannot be morphed and why, one sentence each
};

/// Pairs the grids of the inputs by name; of several of one name, the second is paired with the second and so
/// on. Left out, with a note: grids of types that cannot be morphed, and grids whose type differs from that
/// of the first input that has this name. `onlyNamed`: of inputs whose grid was named (`file.vdb:grid`) take
/// that grid alone.
GridSets pairGrids(const std::vector<LoadedObject>& inputs, bool onlyNamed = false);

/// The set of the grids that the inputs' shapes were read from where these are fog, whatever their names; it
/// is named after the first of them.
GridSet shapeSet(const std::vector<LoadedObject>& inputs);

/// A set's grids, one per input, null where it has none; three parts of a vector field are joined to one grid, and
/// splitParts() makes them three again. Voxels are loaded when they are first accessed. Throws IoError.
std::vector<openvdb::GridBase::ConstPtr> readGrids(const GridSet& set,
                                                   const std::vector<LoadedObject>& inputs);

}  // namespace slicemorph

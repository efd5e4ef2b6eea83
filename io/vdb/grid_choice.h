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

/// A grid's name without the number that VdbEntry adds: `density[1]`, the second grid named density, is
/// `density`.
std::string plainName(const VdbEntry& entry);

/// Whether a grid of this name is what a liquid's surface is called: `phi`, `liquid`, `fluid_surface`. Not so
/// `surface`, the name that any level set may have.
bool isLiquidName(const std::string& name);

/// Whether a grid of this name is no part of what moves in a simulation, but stands in it or feeds it:
/// `phi_obstacle`, `collision`, `phiOutflow`.
bool isStaticName(const std::string& name);

/// A grid that may be a file's shape.
struct GridCandidate {
  size_t index = 0;
  bool isStatic = false;  ///< by its name, or as it is the same in other files of the simulation
  std::string why;        ///< what ranks it, part of a sentence: "a level set named as liquids are"
};

/// The scalar grids in the order in which they are tried where none is named: those of class level set, of these first
/// what is named as liquids' surfaces are, then `density`, then level sets that are dense by the file's statistics
/// (domains of a simulation), unknown classes, other fog volumes; last of all what is static. `besides`: other files
/// of the same simulation; of several level sets one that is the same in all of them is static. Throws InputError,
/// which lists the file's grids, where there is none.
std::vector<GridCandidate> gridCandidates(const VdbFile& file, const std::string& path,
                                          const std::vector<std::string>& besides = {});

/// Their indices.
std::vector<size_t> gridsToTry(const VdbFile& file, const std::string& path);

/// A float grid as it is, a double grid converted; null for any other.
FloatGrid::ConstPtr asFloatGrid(const openvdb::GridBase::Ptr& grid);

/// Index of the vector grid that holds colours, by its name (isColorName): "Cd" before "color" before others.
std::optional<size_t> findColors(const VdbFile& file);

/// A grid of float vectors as it is, one of doubles converted; null for any other.
openvdb::Vec3SGrid::ConstPtr asColorGrid(const openvdb::GridBase::Ptr& grid);

}  // namespace slicemorph

#pragma once

#include "slicemorph/io/vdb_reader.h"

#include <array>
#include <string>
#include <vector>

namespace slicemorph {

/// Three grids of numbers that are the components of one vector field: `vel.x vel.y vel.z`, `v_x v_y v_z`, `velX velY
/// velZ`.
struct VectorParts {
  std::string name;               ///< what they have in common: `vel`
  std::array<size_t, 3> index{};  ///< in the file
};

/// Those of a file: of one type, on voxels of one transform, each name there once.
std::vector<VectorParts> findVectorParts(const VdbFile& file);

/// Whether a grid has a name that Houdini, Blender and other programs give to velocities: vel, v, velocity.
bool isVelocityName(const std::string& name);

/// The velocities of a file, by the index of their grid, or of the three of their components; such of a name of their own
/// too.
std::vector<std::vector<size_t>> findVelocities(const VdbFile& file, const std::string& ownName = "");

/// The first of a file's velocities, those in one grid before those in three, as float vectors; null where it has none.
openvdb::Vec3SGrid::Ptr readVelocity(const VdbFile& file);

/// One grid of vectors, active where any of the parts is; with the metadata of the first part.
openvdb::GridBase::Ptr joinParts(const std::array<openvdb::GridBase::ConstPtr, 3>& parts,
                                 const std::string& name);

/// The components of a vector grid as three grids of these names, active where it is.
openvdb::GridPtrVec splitParts(const openvdb::GridBase& vectors, const std::vector<std::string>& names);

}  // namespace slicemorph

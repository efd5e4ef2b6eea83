#pragma once

#include "engine/volume/repair_mesh.h"

namespace slicemorph {

/// The colours of a mesh on the active voxels of its level set: at each voxel that of the nearest place of
/// the mesh. Named "Cd". Null where the mesh has none.
openvdb::Vec3SGrid::Ptr colorsAround(const FloatGrid& levelSet, const PolygonMesh& mesh);

/// The same from a grid of colours on any transform: trilinear between its active voxels; what is further
/// away takes the colour of the nearest coloured voxel of the surface.
openvdb::Vec3SGrid::Ptr colorsAround(const FloatGrid& levelSet, const openvdb::Vec3SGrid& colors);

/// Colours at world points: trilinear between active voxels alone; beyond them that of the nearest one within
/// four voxels, else black.
std::vector<openvdb::Vec3s> colorsAt(const openvdb::Vec3SGrid& colors,
                                     const std::vector<openvdb::Vec3s>& points);

/// Whether a grid's name is one that hosts give to colours (Cd, color, ...).
bool isColorName(const std::string& name);

}  // namespace slicemorph

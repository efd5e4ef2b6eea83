#pragma once

#include "engine/volume/repair_mesh.h"

namespace slicemorph {

/// The colours of a mesh on the active voxels of its level set: at each voxel the colour of the nearest point
/// of the mesh, of pictures on it the mean over a voxel's size. Named "Cd". Null if the mesh has no colours.
openvdb::Vec3SGrid::Ptr colorsAround(const FloatGrid& levelSet, const PolygonMesh& mesh);

/// The same from a grid of colours on any transform: trilinear between its active voxels; other voxels take
/// the colour of the nearest coloured voxel of the surface. Null if no voxel gets a colour.
openvdb::Vec3SGrid::Ptr colorsAround(const FloatGrid& levelSet, const openvdb::Vec3SGrid& colors);

/// Colours at world points: trilinear among active voxels; beyond them the nearest one's within four voxels,
/// else black.
std::vector<openvdb::Vec3s> colorsAt(const openvdb::Vec3SGrid& colors,
                                     const std::vector<openvdb::Vec3s>& points);

/// Whether a grid's name is one that host programs use for colours (Cd, color, ...).
bool isColorName(const std::string& name);

}  // namespace slicemorph

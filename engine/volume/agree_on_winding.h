#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>

namespace slicemorph {

struct AgreedWinding {
  std::vector<openvdb::Vec3I> triangles;
  std::vector<std::uint32_t> patch;  ///< per triangle: its set, connected across edges with two faces
  std::vector<std::uint32_t> shell;  ///< per triangle: its set, connected across any edge
  /// Per triangle: the part of its patch, connected across edges with two faces, in which windings agreed as found.
  std::vector<std::uint32_t> piece;
  size_t shells = 0;       ///< number of shells
  size_t nonManifold = 0;  ///< edges with more than two faces
  size_t twisted = 0;      ///< edges with two faces whose windings cannot be made to agree
  size_t turned = 0;       ///< triangles whose winding was changed
};

/// Makes the windings of neighbours across edges with two faces agree. In each patch the winding of the
/// majority is kept.
AgreedWinding agreeOnWinding(std::vector<openvdb::Vec3I> triangles);

/// The triangles of each set (a patch or a shell, named per triangle), the sets in the order of their first triangle.
std::vector<std::vector<std::uint32_t>> trianglesOfSets(const std::vector<std::uint32_t>& setOf);

}  // namespace slicemorph

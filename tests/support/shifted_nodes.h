#pragma once

#include "engine/rebuild/image_nodes.h"

#include <vector>

namespace slicemorph {

/// Nodes, three voxels apart, of as many objects as there are shifts; positions on these are those of the in-between, shifted.
inline ImageNodes shiftedNodes(const ImageLattice& on, const std::vector<Vec3d>& shifts) {
  ImageNodes nodes = imageNodes(on, Carrying(), 3 * on.spacing()[0]);
  const std::vector<openvdb::Vec3s> positions = nodes.map.at;
  nodes.map.objects = shifts.size();
  nodes.map.at.clear();
  for (const openvdb::Vec3s& p : positions)
    for (const Vec3d& s : shifts) nodes.map.at.push_back(p + openvdb::Vec3s(s));
  return nodes;
}

}  // namespace slicemorph

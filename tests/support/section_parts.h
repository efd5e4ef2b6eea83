#pragma once

#include "slicemorph/conventions.h"

#include <cmath>
#include <set>

namespace slicemorph {

/// Number of connected parts of the inside on the plane at `position` (world units) along an axis.
inline int sectionParts(const FloatGrid& grid, int axis, double position) {
  auto accessor = grid.getConstAccessor();
  openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  box.min()[axis] = box.max()[axis] = int(std::lround(position / grid.voxelSize()[0]));
  std::set<openvdb::Coord> left;
  for (auto it = box.begin(); it; ++it)
    if (accessor.getValue(*it) < 0) left.insert(*it);
  int parts = 0;
  while (!left.empty()) {
    ++parts;
    std::vector<openvdb::Coord> front{*left.begin()};
    left.erase(left.begin());
    while (!front.empty()) {
      const openvdb::Coord c = front.back();
      front.pop_back();
      for (int a = 0; a < 3; ++a)
        for (int side : {-1, 1}) {
          openvdb::Coord next = c;
          next[a] += side;
          if (left.erase(next)) front.push_back(next);
        }
    }
  }
  return parts;
}

}  // namespace slicemorph

#include "engine/spine/geodesics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slicemorph {

InsideNodes::InsideNodes(const DistanceField& field, size_t most, int along) {
  const auto& n = field.size();
  for (int stride = std::max(1, std::max({n[0], n[1], n[2]}) / along);
       position.empty() || position.size() > most; ++stride) {
    position.clear(), share.clear(), depth.clear(), at.clear();
    spacing = stride * field.spacing();
    for (int z = 0; z < n[2]; z += stride)
      for (int y = 0; y < n[1]; y += stride)
        for (int x = 0; x < n[0]; x += stride) {
          const double d = field.nodeDistance(x, y, z), inside = 0.5 - d / spacing;
          if (!(inside > 0)) continue;
          position.push_back(field.nodePosition(x, y, z));
          share.push_back(std::min(inside, 1.0));
          depth.push_back(-d);
          at.emplace_back(x / stride, y / stride, z / stride);
        }
    if (spacing > field.spacing() * (n[0] + n[1] + n[2])) break;  // nothing inside
  }
}

double InsideNodes::volume() const {
  return std::accumulate(share.begin(), share.end(), 0.0) * spacing * spacing * spacing;
}

double InsideNodes::bodyShare(size_t i) const {
  constexpr double kOutside = 0.25, kLeast = 0.05;  // of the prototype that chose turns by inner distances
  return depth[i] > -kOutside * spacing ? std::max(share[i], kLeast) : 0;
}

Geodesics::Geodesics(const InsideNodes& nodes) : neighbours_(nodes.position.size()) {
  openvdb::CoordBBox box;
  for (const auto& c : nodes.at) box.expand(c);
  const openvdb::Coord size = box.dim();
  const auto index = [&](const openvdb::Coord& c) {
    const openvdb::Coord o = c - box.min();
    return (size_t(o[2]) * size[1] + o[1]) * size[0] + o[0];
  };
  std::vector<int> number(size_t(size[0]) * size[1] * size[2], -1);
  for (size_t i = 0; i < nodes.at.size(); ++i) number[index(nodes.at[i])] = int(i);
  for (size_t i = 0; i < nodes.at.size(); ++i)
    for (auto d = openvdb::CoordBBox(openvdb::Coord(-1), openvdb::Coord(1)).begin(); d; ++d) {
      const openvdb::Coord c = nodes.at[i] + *d;
      if (*d == openvdb::Coord(0) || !box.isInside(c)) continue;
      const int other = number[index(c)];
      if (other >= 0) neighbours_[i].push_back({size_t(other), nodes.spacing * (*d).asVec3d().length()});
    }
}

Geodesics::Distances Geodesics::from(size_t start) const {
  return {shortestPaths(neighbours_.size(), start, [&](size_t i, const auto& visit) {
    for (const Neighbour& n : neighbours_[i]) visit(n.node, n.distance);
  })};
}

size_t Geodesics::Distances::farthest() const {
  size_t best = 0;
  double most = -1;
  for (size_t i = 0; i < length.size(); ++i)
    if (std::isfinite(length[i]) && length[i] > most) most = length[i], best = i;
  return best;
}

}  // namespace slicemorph

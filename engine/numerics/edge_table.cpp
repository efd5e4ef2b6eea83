#include "engine/numerics/edge_table.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace slicemorph {

using Index = HalfEdge::Index;

EdgeTable::EdgeTable(const std::vector<openvdb::Vec3I>& triangles) : halves_(3 * triangles.size()) {
  const auto forEachSide = [&](const auto& visit) {
    for (Index corner = 0; corner < halves_.size(); ++corner) {
      const openvdb::Vec3I& t = triangles[corner / 3];
      visit(corner, t[int(corner % 3)], t[int((corner + 1) % 3)]);
    }
  };
  Index points = 0;
  for (const openvdb::Vec3I& t : triangles) points = std::max({points, t[0] + 1, t[1] + 1, t[2] + 1});
  // Counting sort into buckets by lower point, which is much faster than sorting everything at once.
  std::vector<Index> next(size_t(points) + 2, 0);
  forEachSide([&](Index, Index p, Index q) { ++next[std::min(p, q) + 2]; });
  std::partial_sum(next.begin(), next.end(), next.begin());
  forEachSide([&](Index corner, Index p, Index q) {
    halves_[next[std::min(p, q) + 1]++] = {std::min(p, q), std::max(p, q), corner, p < q};
  });
  for (Index p = 0; p < points; ++p)
    std::sort(halves_.begin() + next[p], halves_.begin() + next[p + 1],
              [](const HalfEdge& a, const HalfEdge& b) {
                return std::tie(a.high, a.corner) < std::tie(b.high, b.corner);
              });
  for (size_t i = 0; i < halves_.size(); ++i)
    if (i == 0 || halves_[i].low != halves_[i - 1].low || halves_[i].high != halves_[i - 1].high)
      starts_.push_back(Index(i));
  starts_.push_back(Index(halves_.size()));
}

}  // namespace slicemorph

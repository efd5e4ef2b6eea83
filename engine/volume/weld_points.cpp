#include "engine/volume/weld_points.h"

#include <algorithm>
#include <numeric>

namespace slicemorph {

namespace {

using openvdb::Vec3s;
using Index = std::uint32_t;

bool lessByPosition(const Vec3s& a, const Vec3s& b) {
  for (int i = 0; i < 3; ++i) {
    if (a[i] != b[i]) return a[i] < b[i];
  }
  return false;
}

}  // namespace

WeldedPoints weldPoints(const PolygonMesh& mesh) {
  const size_t count = mesh.points.size();
  std::vector<Index> order(count), first(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return lessByPosition(mesh.points[a], mesh.points[b]); });
  for (size_t i = 0; i < count; ++i) {
    const bool same = i > 0 && mesh.points[order[i]] == mesh.points[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  std::vector<bool> used(count, false);
  for (Index corner : mesh.corners) used[corner] = true;

  WeldedPoints result;
  result.newIndex.assign(count, kNoPoint);
  std::vector<Index> kept(count, kNoPoint);
  for (size_t i = 0; i < count; ++i) {
    if (!used[i]) {
      ++result.unused;
      continue;
    }
    Index& target = kept[first[i]];
    if (target == kNoPoint) {
      target = Index(result.points.size());
      result.points.push_back(mesh.points[i]);
    } else {
      ++result.merged;
    }
    result.newIndex[i] = target;
  }
  result.merged -= std::min(result.merged, mesh.importCopies);
  return result;
}

}  // namespace slicemorph

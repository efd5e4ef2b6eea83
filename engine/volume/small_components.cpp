#include "engine/volume/small_components.h"

#include "engine/numerics/disjoint_sets.h"
#include "engine/volume/leaf.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <unordered_map>

namespace slicemorph {

namespace {

/// Components with fewer than kDust (3^3) inside voxels and at most this share of all are not counted as
/// pieces; tips thinner than a voxel leave such fragments. Guarded by DustIsNoPiece in
/// small_components_test.cpp.
constexpr size_t kDust = 27;
constexpr double kDustShare = 1e-3;

using Leaf = openvdb::FloatTree::LeafNodeType;
using Set = DisjointSets::Index;
/// Largest share of the inside voxels that a removable component may have; documented in the header, guarded
/// by TheSmallestAreRemoved and LargePartsStay in small_components_test.cpp.
constexpr double kSmallComponent = 0.03;

/// Depth of a voxel that is filled, voxels: as good as none, which the surface does not see among deeper ones.
constexpr double kFilled = 1e-3;

/// One leaf's inside voxels labelled by component, -1 outside.
struct LeafParts {
  std::vector<short> label;
  std::vector<int> sizes;
};

LeafParts labelLeaf(const Leaf& leaf) {
  const float* v = leaf.buffer().data();
  DisjointSets sets(kLeafSize);
  for (int x = 0; x < kLeaf; ++x)
    for (int y = 0; y < kLeaf; ++y)
      for (int z = 0; z < kLeaf; ++z) {
        const int i = int(leafOffset(x, y, z));
        if (!(v[i] < 0)) continue;
        if (x > 0 && v[i - 64] < 0) sets.join(Set(i), Set(i - 64));
        if (y > 0 && v[i - 8] < 0) sets.join(Set(i), Set(i - 8));
        if (z > 0 && v[i - 1] < 0) sets.join(Set(i), Set(i - 1));
      }
  LeafParts parts;
  parts.label.assign(kLeafSize, -1);
  for (int i = 0; i < kLeafSize; ++i) {
    if (!(v[i] < 0)) continue;
    const size_t root = sets.find(Set(i));  // the smallest index of its component, hence already labelled
    if (root == size_t(i))
      parts.label[i] = short(parts.sizes.size()), parts.sizes.push_back(0);
    else
      parts.label[i] = parts.label[root];
    ++parts.sizes[size_t(parts.label[i])];
  }
  return parts;
}

/// The components of the whole inside. Component 0 is everything connected to an inside tile.
struct Parts {
  std::vector<const Leaf*> leaves;
  std::vector<LeafParts> inLeaf;
  std::vector<size_t> first;  ///< global index of each leaf's first component
  std::vector<size_t> root;   ///< per component
  std::vector<size_t> sizes;  ///< per root: voxels in leaves
  bool tiles = false;         ///< whether component 0 exists

  std::vector<size_t> roots() const {
    std::vector<size_t> result;
    for (size_t i = 0; i < root.size(); ++i)
      if (root[i] == i && (i > 0 || tiles)) result.push_back(i);
    return result;
  }
};

Parts findParts(const FloatGrid& grid) {
  Parts parts;
  grid.tree().getNodes(parts.leaves);
  const size_t n = parts.leaves.size();
  parts.inLeaf.resize(n);
  tbb::parallel_for(size_t(0), n, [&](size_t i) { parts.inLeaf[i] = labelLeaf(*parts.leaves[i]); });
  std::unordered_map<openvdb::Coord, size_t> index;
  index.reserve(n);
  size_t count = 1;
  for (size_t i = 0; i < n; ++i) {
    index.emplace(parts.leaves[i]->origin(), i);
    parts.first.push_back(count);
    count += parts.inLeaf[i].sizes.size();
  }
  DisjointSets sets(count);
  auto accessor = grid.getConstAccessor();
  const int strides[3] = {64, 8, 1};
  for (size_t i = 0; i < n; ++i)
    for (int axis = 0; axis < 3; ++axis)
      for (int side : {0, kLeaf - 1}) {
        openvdb::Coord next = parts.leaves[i]->origin();
        next[axis] += side ? kLeaf : -kLeaf;
        const auto neighbour = index.find(next);
        const bool tile = neighbour == index.end() && accessor.getValue(next) < 0;
        // each pair of leaves is joined once, from the lower one
        if (neighbour == index.end() ? !tile : side == 0) continue;
        for (int a = 0; a < kLeaf; ++a)
          for (int b = 0; b < kLeaf; ++b) {
            const int plane = a * strides[(axis + 1) % 3] + b * strides[(axis + 2) % 3];
            const short mine = parts.inLeaf[i].label[size_t(plane + side * strides[axis])];
            if (mine < 0) continue;
            const size_t me = parts.first[i] + size_t(mine);
            if (tile) {
              sets.join(0, Set(me));
              parts.tiles = true;
              continue;
            }
            const short other = parts.inLeaf[neighbour->second].label[size_t(plane)];
            if (other >= 0) sets.join(Set(me), Set(parts.first[neighbour->second] + size_t(other)));
          }
      }
  parts.root.resize(count);
  parts.sizes.assign(count, 0);
  for (size_t i = 0; i < count; ++i) parts.root[i] = sets.find(Set(i));
  for (size_t i = 0; i < n; ++i)
    for (size_t p = 0; p < parts.inLeaf[i].sizes.size(); ++p)
      parts.sizes[parts.root[parts.first[i] + p]] += size_t(parts.inLeaf[i].sizes[p]);
  return parts;
}

/// Sets a component's voxels to outside, and removes the narrow band around it where no other inside
/// voxel is near.
void remove(FloatGrid& grid, const std::vector<openvdb::Coord>& voxels) {
  constexpr int kReach = int(kHalfWidth) + 1;
  auto accessor = grid.getAccessor();
  const float background = grid.background();
  openvdb::CoordBBox box;
  for (const openvdb::Coord& c : voxels) accessor.setValueOff(c, background), box.expand(c);
  box.expand(kReach);
  for (auto it = box.begin(); it; ++it) {
    if (!accessor.isValueOn(*it)) continue;
    bool near = false;
    for (auto n = openvdb::CoordBBox(*it - openvdb::Coord(kReach), *it + openvdb::Coord(kReach)).begin();
         n && !near; ++n)
      near = accessor.getValue(*n) < 0;
    if (!near) accessor.setValueOff(*it, background);
  }
}

}  // namespace

int countPieces(const FloatGrid& levelSet) {
  const Parts parts = findParts(levelSet);
  size_t total = 0;
  for (size_t r : parts.roots()) total += parts.sizes[r];
  int pieces = 0;
  for (size_t r : parts.roots())
    pieces += r == 0 || parts.sizes[r] >= kDust || double(parts.sizes[r]) > kDustShare * double(total);
  return std::max(pieces, 1);
}

std::vector<LooseComponent> looseComponents(const FloatGrid& levelSet, int allowed) {
  const Parts parts = findParts(levelSet);
  std::vector<size_t> roots = parts.roots();
  if (int(roots.size()) <= allowed) return {};
  size_t total = 0;
  for (size_t r : roots) total += parts.sizes[r];
  std::stable_sort(roots.begin(), roots.end(),
                   [&](size_t a, size_t b) { return parts.sizes[a] < parts.sizes[b]; });
  std::vector<LooseComponent> loose;
  std::unordered_map<size_t, size_t> number;  // of a root among them
  for (size_t i = 0; i + size_t(allowed) < roots.size(); ++i) {
    if (roots[i] == 0) continue;
    number.emplace(roots[i], loose.size());
    loose.push_back({{}, double(parts.sizes[roots[i]]) / double(total)});
  }
  for (size_t i = 0; i < parts.leaves.size(); ++i)
    for (int v = 0; v < kLeafSize; ++v) {
      const short label = parts.inLeaf[i].label[size_t(v)];
      if (label < 0) continue;
      const auto found = number.find(parts.root[parts.first[i] + size_t(label)]);
      if (found != number.end())
        loose[found->second].voxels.push_back(parts.leaves[i]->offsetToGlobalCoord(openvdb::Index(v)));
    }
  return loose;
}

int removeSmallComponents(FloatGrid& levelSet, const std::vector<LooseComponent>& loose) {
  int removed = 0;
  for (const LooseComponent& component : loose) {
    if (!(component.share < kSmallComponent)) continue;
    remove(levelSet, component.voxels);
    ++removed;
  }
  return removed;
}

int fillVoxelVoids(FloatGrid& levelSet) {
  std::vector<const Leaf*> leaves;
  levelSet.tree().getNodes(leaves);
  std::vector<std::vector<openvdb::Coord>> found(leaves.size());
  tbb::parallel_for(size_t(0), leaves.size(), [&](size_t i) {
    const float* v = leaves[i]->buffer().data();
    const FloatGrid& grid = levelSet;
    auto values = grid.getConstAccessor();
    for (int o = 0; o < kLeafSize; ++o) {
      if (v[o] < 0) continue;
      const openvdb::Coord c = leaves[i]->offsetToGlobalCoord(openvdb::Index(o));
      bool alone = true;
      for (int axis = 0; axis < 3 && alone; ++axis)
        for (int side : {-1, 1}) {
          openvdb::Coord n = c;
          n[axis] += side;
          alone = alone && values.getValue(n) < 0;
        }
      if (alone) found[i].push_back(c);
    }
  });
  // No two are neighbours, so none is filled because another one is.
  int filled = 0;
  auto values = levelSet.getAccessor();
  for (const auto& voids : found)
    for (const openvdb::Coord& c : voids)
      values.setValueOn(c, float(-kFilled * levelSet.voxelSize()[0])), ++filled;
  return filled;
}

}  // namespace slicemorph

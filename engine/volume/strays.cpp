#include "engine/volume/strays.h"

#include "engine/numerics/disjoint_sets.h"

#include <openvdb/tools/SignedFloodFill.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using Leaf = openvdb::FloatTree::LeafNodeType;

/// Strays hold at most this share of the active voxels: a single voxel has a narrow band of 150, a ball of 16 voxels
/// one of 5000. They make the box this many times longer: the matching's lattices then have seven nodes along the
/// rest.
constexpr double kMostShare = 0.1, kFar = 16;

struct StrayPart {
  CoordBBox box;
  double voxels = 0;
  std::vector<Coord> leaves;
};

double longestSideOf(const CoordBBox& box) {
  return box.empty() ? 0 : double(box.dim()[int(box.maxExtent())]);
}

/// The parts of leaves that touch, the largest first; of equal ones the first in space.
std::vector<StrayPart> strayPartsOf(const FloatGrid& grid) {
  std::map<Coord, openvdb::Index32> index;
  std::vector<const Leaf*> leaves;
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    if (!leaf->isEmpty())
      index.emplace(leaf->origin(), openvdb::Index32(leaves.size())), leaves.push_back(&*leaf);
  DisjointSets sets(leaves.size());
  for (const auto& [origin, i] : index)
    for (int n = 0; n < 13; ++n) {  // half of the neighbours; the others have this one
      const Coord step(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
      const auto other = index.find(origin + Coord(step[0] * 8, step[1] * 8, step[2] * 8));
      if (other != index.end()) sets.join(i, other->second);
    }
  std::map<openvdb::Index32, StrayPart> byRoot;
  for (openvdb::Index32 i = 0; i < leaves.size(); ++i) {
    StrayPart& part = byRoot[sets.find(i)];
    leaves[i]->evalActiveBoundingBox(part.box);
    part.voxels += double(leaves[i]->onVoxelCount());
    part.leaves.push_back(leaves[i]->origin());
  }
  std::vector<StrayPart> parts;
  for (auto& [root, part] : byRoot) parts.push_back(std::move(part));
  std::stable_sort(parts.begin(), parts.end(), [](const StrayPart& a, const StrayPart& b) {
    return std::pair(-a.voxels, a.box.min()) < std::pair(-b.voxels, b.box.min());
  });
  return parts;
}

}  // namespace

Strays findStrays(const FloatGrid& grid) {
  Strays strays;
  strays.body = grid.evalActiveVoxelBoundingBox();
  if (grid.tree().activeTileCount() > 0) return strays;
  const std::vector<StrayPart> parts = strayPartsOf(grid);
  double all = 0, kept = 0;
  for (const StrayPart& part : parts) all += part.voxels;
  CoordBBox body;
  size_t count = 0;
  while (count < parts.size() && kept < (1 - kMostShare) * all)
    body.expand(parts[count].box), kept += parts[count].voxels, ++count;
  // Small parts near the body belong to it.
  const double longest = longestSideOf(body), reach = kFar / 2 * longest;
  CoordBBox around = body;
  around.expand(int(std::min(reach, double(1 << 28))));
  CoordBBox near = body;
  std::vector<Coord> leaves;
  for (size_t i = count; i < parts.size(); ++i) {
    if (around.isInside(parts[i].box)) {
      near.expand(parts[i].box);
      continue;
    }
    leaves.insert(leaves.end(), parts[i].leaves.begin(), parts[i].leaves.end());
    strays.share += parts[i].voxels / all, ++strays.pieces;
  }
  if (leaves.empty() || longestSideOf(strays.body) <= kFar * longest) {
    strays.share = 0, strays.pieces = 0;
    return strays;
  }
  std::sort(leaves.begin(), leaves.end());
  strays.body = near, strays.leaves = std::move(leaves);
  return strays;
}

FloatGrid::Ptr withoutStrays(const FloatGrid& levelSet, const Strays& strays) {
  const FloatGrid::Ptr kept = FloatGrid::create(levelSet.background());
  kept->insertMeta(levelSet);
  kept->setTransform(levelSet.transform().copy());
  kept->setName(levelSet.getName());
  for (auto leaf = levelSet.tree().cbeginLeaf(); leaf; ++leaf)
    if (!std::binary_search(strays.leaves.begin(), strays.leaves.end(), leaf->origin()))
      kept->tree().addLeaf(new Leaf(*leaf));
  openvdb::tools::signedFloodFill(kept->tree());
  return kept;
}

}  // namespace slicemorph

#include "engine/rebuild/warp_colors.h"

#include "engine/blend/node_positions.h"
#include "engine/volume/color_sampler.h"

#include <openvdb/tree/LeafManager.h>

#include <algorithm>

namespace slicemorph {

namespace {

using openvdb::Vec3s;
using openvdb::Vec3SGrid;

/// Weights below this are treated as 0: rounding only, far below a step of an 8-bit colour.
constexpr double kNothing = 1e-6;

/// One object's colour for a position (world) to which the map leads: interpolated if all voxels around it
/// are coloured, else that of the nearest surface point.
std::optional<Vec3s> surfaceColor(const CarriedColors& source, const ColorSampler& sampler,
                                  const Vec3d& position) {
  constexpr double kWhole = 1 - 1e-4;
  const ColorMean there = sampler.between(sampler.toIndex(position));
  return there.weight() > kWhole ? there.value() : sampler.at(source.field->closest(position));
}

}  // namespace

Vec3SGrid::Ptr warpColors(const FloatGrid& surface, const std::vector<CarriedColors>& colors,
                          const NodeMap& nodes, const LocalWeights& weights) {
  auto tree = std::make_shared<openvdb::Vec3STree>(surface.tree(), Vec3s(0.f), openvdb::TopologyCopy());
  tree->voxelizeActiveTiles();
  auto result = Vec3SGrid::create(tree);
  result->setTransform(surface.transform().copy());
  result->setName("Cd");
  const NodePositions finder(nodes);
  const int step = nodes.step;
  const std::vector<size_t> regionShapes = weights.regionObjects();
  using Leaf = openvdb::Vec3STree::LeafNodeType;
  const auto fillCell = [&](Leaf& leaf, const openvdb::Coord& first,
                            std::vector<std::vector<Vec3s>>& positions,
                            const std::vector<ColorSampler>& samplers) {
    bool any = false;
    for (int v = 0; v < step * step * step && !any; ++v)
      any = leaf.isValueOn(Leaf::coordToOffset(first.offsetBy(v / (step * step), v / step % step, v % step)));
    const openvdb::Coord node = openvdb::Coord::floor((leaf.origin() + first).asVec3d() / step);
    if (!any || !nodes.inside(node[0], node[1], node[2]) ||
        !nodes.inside(node[0] + 1, node[1] + 1, node[2] + 1))
      return;
    const auto find = [&](size_t shape) {
      positions[shape].resize(size_t(step) * step * step);
      finder.find(node[0], node[1], node[2], shape, positions[shape]);
    };
    for (const CarriedColors& c : colors) find(c.shape);
    for (size_t shape : regionShapes) find(shape);
    std::vector<Vec3s> at(nodes.objects, Vec3s(0.f));
    Weights local = weights.whole();
    for (int v = 0; v < step * step * step; ++v) {
      const auto offset = Leaf::coordToOffset(first.offsetBy(v / (step * step), v / step % step, v % step));
      if (!leaf.isValueOn(offset)) continue;
      for (size_t shape : regionShapes) at[shape] = positions[shape][size_t(v)];
      if (weights.vary()) weights.find(at.data(), local.data());
      ColorMean sum, unweighted;
      for (size_t n = 0; n < colors.size(); ++n) {
        const CarriedColors& c = colors[n];
        const Vec3d position = c.field->anchor() + Vec3d(positions[c.shape][size_t(v)]);
        const std::optional<Vec3s> color = surfaceColor(c, samplers[n], position);
        if (!color) continue;
        const double weight = weights.vary() ? local[c.object] : c.weight;
        if (weight > kNothing) sum.add(*color, weight);
        unweighted.add(*color, 1);
      }
      // If no object with colours has weight here, their unweighted mean is used.
      const std::optional<Vec3s> color = sum.value() ? sum.value() : unweighted.value();
      leaf.setValueOnly(offset, color.value_or(Vec3s(0.f)));
    }
  };
  openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(*tree);
  leaves.foreach ([&](Leaf& leaf, size_t) {
    std::vector<std::vector<Vec3s>> positions(nodes.objects);
    std::vector<ColorSampler> samplers;
    samplers.reserve(colors.size());
    for (const CarriedColors& c : colors) samplers.emplace_back(*c.grid);
    for (int x = 0; x < kLeaf; x += step)
      for (int y = 0; y < kLeaf; y += step)
        for (int z = 0; z < kLeaf; z += step) fillCell(leaf, {x, y, z}, positions, samplers);
  });
  return result;
}

}  // namespace slicemorph

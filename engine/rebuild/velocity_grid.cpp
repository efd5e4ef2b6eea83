#include "engine/rebuild/velocity_grid.h"

#include "engine/blend/box_nodes.h"
#include "engine/blend/node_positions.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace slicemorph {

namespace {

using openvdb::Coord;
using openvdb::Vec3s;

/// Moved by less than this, in cells, a cell does not reach into the next one: rounding.
constexpr double kTouch = 1e-3;

/// One flag for each cell between the nodes of a map, at its first node.
using CellFlags = std::vector<char>;

/// Nodes that have one further on every side, and so cells that are whole and have splines.
bool isInner(const NodeMap& nodes, const Coord& c) {
  return nodes.inside(c[0] - 1, c[1] - 1, c[2] - 1) && nodes.inside(c[0] + 2, c[1] + 2, c[2] + 2);
}

size_t countOf(const NodeMap& nodes) { return size_t(nodes.size[0]) * nodes.size[1] * nodes.size[2]; }

/// The cells that hold active voxels.
CellFlags cellsOf(const openvdb::MaskTree& body, const NodeMap& nodes) {
  using Leaf = openvdb::MaskTree::LeafNodeType;
  CellFlags cells(countOf(nodes), 0);
  std::vector<const Leaf*> leaves;
  body.getNodes(leaves);
  const int step = nodes.step;
  // The bits of a cell in a word of a leaf's mask, which holds 8 x 8 voxels of one x, z fastest.
  std::uint64_t square = 0;
  for (int y = 0; y < step; ++y)
    for (int z = 0; z < step; ++z) square |= std::uint64_t(1) << (y * kLeaf + z);
  // A cell is in one leaf: leaves write to no common one.
  tbb::parallel_for(size_t(0), leaves.size(), [&](size_t l) {
    const auto& mask = leaves[l]->getValueMask();
    for (int x = 0; x < kLeaf; ++x) {
      const std::uint64_t word = mask.getWord<std::uint64_t>(openvdb::Index(x));
      for (int y = 0; y < kLeaf && word; y += step)
        for (int z = 0; z < kLeaf; z += step) {
          if (!(word & square << (y * kLeaf + z))) continue;
          const Coord c = leaves[l]->origin().offsetBy(x, y, z) >> (step == 8 ? 3 : 2);
          if (isInner(nodes, c)) cells[nodes.index(c[0], c[1], c[2])] = 1;
        }
    }
  });
  return cells;
}

/// Calls `action(c)` for the first node c of every cell that is marked, in a fixed order.
template <typename Action>
void forCells(const NodeMap& nodes, const CellFlags& cells, const Action& action) {
  for (int z = 0; z < nodes.size[2]; ++z)
    for (int y = 0; y < nodes.size[1]; ++y)
      for (int x = 0; x < nodes.size[0]; ++x) {
        const Coord c = nodes.origin + Coord(x, y, z);
        if (cells[nodes.index(c[0], c[1], c[2])]) action(c);
      }
}

Vec3s meanVelocity(const NodeMap& nodes, const Coord& c) {
  Vec3s sum(0.f);
  for (int corner = 0; corner < 8; ++corner)
    sum += nodes.at[nodes.index(c[0] + (corner & 1), c[1] + (corner >> 1 & 1), c[2] + (corner >> 2))];
  return sum * 0.125f;
}

/// Marks the cells that a cell touches where it is moved by `by`, in cells.
void markMoved(const NodeMap& nodes, const Coord& cell, const Vec3d& by, CellFlags& cells) {
  const Vec3d at = cell.asVec3d() + by;
  const Coord low = Coord::floor(at + Vec3d(kTouch)), high = Coord::ceil(at - Vec3d(kTouch));
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i)
        if (isInner(nodes, {i, j, k})) cells[nodes.index(i, j, k)] = 1;
}

/// The way of a cell within `reach` units of time, in cells.
Vec3d pathOf(const NodeMap& nodes, const Coord& cell, const openvdb::math::Transform& transform,
             double reach) {
  const Vec3d velocity(meanVelocity(nodes, cell));
  Vec3d path = transform.baseMap()->applyInverseJacobian(velocity) * (reach / nodes.step);
  const double length = path.length(), most = double(kMostReach) / nodes.step;
  return length > most ? path * (most / length) : path;
}

/// How far the cells move at most within `reach` units of time, in voxels, rounded up.
int farthest(const NodeMap& nodes, const CellFlags& cells, const openvdb::math::Transform& transform,
             double reach) {
  double most = 0;
  if (reach > 0)
    forCells(nodes, cells,
             [&](const Coord& c) { most = std::max(most, pathOf(nodes, c, transform, reach).lengthSqr()); });
  return int(std::ceil(std::sqrt(most) * nodes.step));
}

/// The cells, and those that they sweep while they move by their velocity for `reach` units of time, both ways.
CellFlags sweptCells(const NodeMap& nodes, const CellFlags& cells, const openvdb::math::Transform& transform,
                     double reach) {
  CellFlags swept = cells;
  if (reach == 0) return swept;
  forCells(nodes, cells, [&](const Coord& c) {
    const Vec3d path = pathOf(nodes, c, transform, reach);
    const int steps = int(std::ceil(path.length()));
    for (int s = 1; s <= steps; ++s)
      for (int side : {-1, 1}) markMoved(nodes, c, path * (side * double(s) / steps), swept);
  });
  return swept;
}

/// The nodes of the cells, and as many further ones on every side; none of those in `but`. Axis by axis: a flag of a cell
/// stands for these nodes along it.
CellFlags nodesOf(const NodeMap& nodes, const CellFlags& cells, int further, const CellFlags& but) {
  CellFlags wanted = cells;
  const std::ptrdiff_t row = nodes.size[0], slab = row * nodes.size[1], count = slab * nodes.size[2];
  for (const std::ptrdiff_t stride : {std::ptrdiff_t(1), row, slab}) {
    const CellFlags from = wanted;
    tbb::parallel_for(std::ptrdiff_t(0), count, [&](std::ptrdiff_t n) {
      for (std::ptrdiff_t cell = n - (1 + further) * stride; cell <= n + further * stride; cell += stride)
        if (cell >= 0 && cell < count) wanted[size_t(n)] |= from[size_t(cell)];
    });
  }
  for (size_t n = 0; n < but.size(); ++n)
    if (but[n]) wanted[n] = 0;
  return wanted;
}

/// Adds the nodes that another map knows, whose box is within this one's.
void addKnown(NodeMap& nodes, const NodeMap& more) {
  nodes.objects = 1, nodes.at.resize(countOf(nodes)), nodes.known.resize(countOf(nodes));
  forNodes(more, [&](const Coord& c, size_t from) {
    const size_t to = nodes.index(c[0], c[1], c[2]);
    if (more.known[from]) nodes.at[to] = more.at[from], nodes.known[to] = 1;
  });
}

/// The most by which trilinear interpolation between the nodes around the cells can be wrong: an eighth of the second
/// differences along each axis.
double interpolationError(const NodeMap& nodes, const CellFlags& cells) {
  const size_t row = size_t(nodes.size[0]), slab = row * size_t(nodes.size[1]), stride[3] = {1, row, slab};
  // Per node that a cell has, and axis.
  const CellFlags corner = nodesOf(nodes, cells, 0, {});
  std::vector<Vec3s> bend(cells.size());
  tbb::parallel_for(0, nodes.size[2], [&](int z) {
    for (size_t n = slab * size_t(z); n < slab * size_t(z + 1); ++n)
      for (int axis = 0; axis < 3 && corner[n]; ++axis)
        bend[n][axis] =
            (nodes.at[n - stride[axis]] - 2.f * nodes.at[n] + nodes.at[n + stride[axis]]).lengthSqr();
  });
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, cells.size()), 0.0,
      [&](const tbb::blocked_range<size_t>& range, double most) {
        for (size_t n = range.begin(); n < range.end(); ++n) {
          if (!cells[n]) continue;
          Vec3s worst(0.f);
          for (size_t c = 0; c < 8; ++c)
            worst =
                openvdb::math::maxComponent(worst, bend[n + (c & 1) + (c >> 1 & 1) * row + (c >> 2) * slab]);
          double sum = 0;
          for (int axis = 0; axis < 3; ++axis) sum += std::sqrt(double(worst[axis])) / 8;
          most = std::max(most, sum);
        }
        return most;
      },
      [](double a, double b) { return std::max(a, b); });
}

/// How many times as large as the voxels the grid's may be.
int coarsening(const NodeMap& nodes, const CellFlags& cells, double tolerance) {
  if (tolerance == 0) return 1;
  const double error = interpolationError(nodes, cells);
  for (int factor : {4, 2}) {
    const double share = double(factor) / nodes.step;
    if (error * share * share <= tolerance) return factor;
  }
  return 1;
}

/// The voxels of the grid: the corners of the cells; of cells of the body at the finest only what is active there.
openvdb::MaskTree voxelsOf(const NodeMap& nodes, const openvdb::MaskTree& body, const CellFlags& cells,
                           const CellFlags& swept, int factor) {
  openvdb::MaskTree tree;
  if (factor == 1) tree.topologyUnion(body);
  openvdb::tree::ValueAccessor<openvdb::MaskTree> voxels(tree);
  const int side = nodes.step / factor;
  forCells(nodes, swept, [&](const Coord& c) {
    if (factor == 1 && cells[nodes.index(c[0], c[1], c[2])]) return;
    for (int x = 0; x <= side; ++x)
      for (int y = 0; y <= side; ++y)
        for (int z = 0; z <= side; ++z)
          voxels.setValueOn(Coord(c[0] * side + x, c[1] * side + y, c[2] * side + z));
  });
  return tree;
}

/// Puts the velocities into the active voxels of a grid whose voxels are `factor` times as large as the nodes' and leaves
/// out those that are 0.
void fillIn(openvdb::Vec3STree& tree, const NodeMap& nodes, int factor) {
  const NodePositions velocities(nodes);
  const int side = nodes.step / factor, step = nodes.step;
  openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(tree);
  leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, size_t) {
    std::vector<Vec3s> cell(size_t(step) * step * step);
    const Coord o = leaf.origin();
    for (int x = 0; x < kLeaf; x += side)
      for (int y = 0; y < kLeaf; y += side)
        for (int z = 0; z < kLeaf; z += side) {
          const int i = (o[0] + x) / side, j = (o[1] + y) / side, k = (o[2] + z) / side;
          bool found = false;
          for (int v = 0; v < side * side * side; ++v) {
            const int a = v / (side * side), b = v / side % side, d = v % side;
            const auto offset = leaf.coordToOffset({x + a, y + b, z + d});
            if (!leaf.isValueOn(offset)) continue;
            if (!nodes.inside(i, j, k) || !nodes.inside(i + 1, j + 1, k + 1)) {
              leaf.setValueOff(offset);  // further than kMostReach
              continue;
            }
            if (side == 1) {
              cell[0] = nodes.at[nodes.index(i, j, k)];
            } else if (!found) {
              velocities.find(i, j, k, 0, cell), found = true;
            }
            const Vec3s& velocity = cell[size_t(((a * step + b) * step + d) * factor)];
            if (velocity == Vec3s(0.f))
              leaf.setValueOff(offset);
            else
              leaf.setValueOnly(offset, velocity);
          }
        }
  });
  openvdb::tools::pruneInactive(tree);
}

}  // namespace

openvdb::MaskTree::Ptr activeVoxels(const openvdb::GridBase& where) {
  openvdb::MaskTree::Ptr tree;
  using Types = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::BoolGrid,
                                  openvdb::MaskGrid>;
  const bool known = where.apply<Types>([&](const auto& grid) {
    tree = std::make_shared<openvdb::MaskTree>(grid.tree(), false, openvdb::TopologyCopy());
  });
  if (!known) throw InputError("no velocities are made where a grid of " + where.valueType() + " is active");
  tree->voxelizeActiveTiles();
  return tree;
}

openvdb::Vec3SGrid::Ptr velocityGrid(int step, const NodeVelocities& velocities,
                                     const openvdb::MaskTree& body, const openvdb::math::Transform& transform,
                                     const VelocityOptions& options) {
  openvdb::CoordBBox box;
  body.evalActiveVoxelBoundingBox(box);
  box.expand(step);
  NodeMap nodes = emptyNodes(box, step);
  CellFlags cells = cellsOf(body, nodes);
  nodes = velocities(nodes, nodesOf(nodes, cells, 0, {}));
  if (const int reach = farthest(nodes, cells, transform, options.reach); reach > 0) {
    box.expand(reach);
    const NodeMap inner = std::exchange(nodes, emptyNodes(box, step));
    addKnown(nodes, inner);
    cells = cellsOf(body, nodes);
  }
  const CellFlags swept = sweptCells(nodes, cells, transform, options.reach);
  // Splines need another node on every side.
  addKnown(nodes, velocities(emptyNodes(box, step), nodesOf(nodes, swept, 1, nodes.known)));
  const int factor = coarsening(nodes, swept, options.tolerance);
  const openvdb::MaskTree voxels = voxelsOf(nodes, body, cells, swept, factor);
  const auto grid = openvdb::Vec3SGrid::create(
      std::make_shared<openvdb::Vec3STree>(voxels, Vec3s(0.f), openvdb::TopologyCopy()));
  grid->setTransform(transform.copy());
  if (factor > 1) grid->transform().preScale(double(factor));
  fillIn(grid->tree(), nodes, factor);
  return grid;
}

}  // namespace slicemorph

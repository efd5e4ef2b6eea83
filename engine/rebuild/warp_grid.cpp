#include "engine/rebuild/warp_grid.h"

#include "engine/blend/node_places.h"
#include "engine/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace slicemorph {

namespace {

/// Which blocks of 8 x 8 x 8 voxels of a grid hold active ones.
class ActiveBlocks {
 public:
  explicit ActiveBlocks(const openvdb::GridBase& grid) {
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) return;
    low_ = blockOf(box.min());
    size_ = blockOf(box.max()) - low_ + openvdb::Coord(1);
    active_.assign(size_t(size_[0]) * size_[1] * size_[2], 0);
  }
  void add(const openvdb::CoordBBox& voxels) {
    const openvdb::CoordBBox blocks(blockOf(voxels.min()), blockOf(voxels.max()));
    for (auto it = blocks.begin(); it; ++it) active_[index(*it)] = 1;
  }
  /// Whether any block meets a box of index space.
  bool meets(const openvdb::BBoxd& box) const {
    openvdb::Coord low = openvdb::Coord::floor(box.min() / kLeaf), high = openvdb::Coord::floor(box.max() / kLeaf);
    low.maxComponent(low_);
    high.minComponent(low_ + size_ - openvdb::Coord(1));
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x)
          if (active_[index({x, y, z})]) return true;
    return false;
  }

 private:
  static openvdb::Coord blockOf(const openvdb::Coord& c) { return openvdb::Coord::floor(c.asVec3d() / kLeaf); }
  size_t index(const openvdb::Coord& block) const {
    const openvdb::Coord c = block - low_;
    return (size_t(c[2]) * size_[1] + c[1]) * size_[0] + c[0];
  }
  openvdb::Coord low_{0, 0, 0}, size_{0, 0, 0};
  std::vector<char> active_;
};

/// How the map to one object turns and stretches: derivatives of its place by the in-between's, both in the world.
Mat3d jacobianAt(const openvdb::Vec3s* corner, const Vec3d& fraction, const Mat3d& perVoxel, int step) {
  Mat3d d;
  for (int axis = 0; axis < 3; ++axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    Vec3d sum(0.0);
    for (int i = 0; i < 4; ++i) {
      const int other = (i & 1) << b | (i >> 1) << c;
      const double w = (i & 1 ? fraction[b] : 1 - fraction[b]) * (i >> 1 ? fraction[c] : 1 - fraction[c]);
      sum += w / step * Vec3d(corner[other | 1 << axis] - corner[other]);
    }
    for (int row = 0; row < 3; ++row) d(row, axis) = sum[row];
  }
  return d * perVoxel;
}

/// The rotation nearest to a matrix (Higham's iteration for the polar factor).
Mat3d rotationOf(Mat3d m) {
  if (!(m.det() > 0)) return Mat3d::identity();
  for (int i = 0; i < 12; ++i) m = (m + m.inverse().transpose()) * 0.5;
  return m;
}

template <typename Value>
Value turned(const Mat3d& back, const Value& v) {
  if constexpr (openvdb::VecTraits<Value>::IsVec) return Value(back * Vec3d(v));
  else return v;
}

template <typename GridType>
class Warper {
  using Value = typename GridType::ValueType;
  using Leaf = typename GridType::TreeType::LeafNodeType;

 public:
  Warper(const std::vector<CarriedGrid>& grids, const NodeMap& nodes, const openvdb::math::Transform& transform,
         bool conserve)
      : nodes_(nodes), places_(nodes), transform_(transform), conserve_(conserve) {
    for (const CarriedGrid& g : grids) {
      if (!(g.weight > 0) || !g.grid) continue;
      carried_.push_back({openvdb::gridConstPtrCast<GridType>(g.grid), g.shape, g.anchor, g.weight, ActiveBlocks(*g.grid)});
      if (!carried_.back().grid) throw InputError("grids of different types cannot be blended: " + g.grid->type());
      for (auto it = carried_.back().grid->cbeginValueOn(); it; ++it) {
        openvdb::CoordBBox box;
        it.getBoundingBox(box);
        carried_.back().blocks.add(box);
      }
    }
    // Index-space steps of the in-between by world-space steps.
    const Vec3d o = transform.indexToWorld(Vec3d(0.0));
    Mat3d worldPerVoxel;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d e(0.0);
      e[axis] = 1;
      const Vec3d column = transform.indexToWorld(e) - o;
      for (int row = 0; row < 3; ++row) worldPerVoxel(row, axis) = column[row];
    }
    voxelPerWorld_ = worldPerVoxel.inverse();
  }

  typename GridType::Ptr run() {
    const GridType& like = *carried_.front().grid;
    auto result = GridType::create(like.background());
    result->setTransform(transform_.copy());
    result->setGridClass(like.getGridClass());
    result->setVectorType(like.getVectorType());
    const std::vector<openvdb::Coord> origins =
        leavesWith(nodes_, [this](int i, int j, int k) { return cellActive(i, j, k); });
    std::vector<Leaf*> leaves(origins.size(), nullptr);
    tbb::parallel_for(size_t(0), origins.size(), [&](size_t i) { leaves[i] = filled(origins[i], like.background()); });
    for (Leaf* leaf : leaves)
      if (leaf) result->tree().addLeaf(leaf);
    return result;
  }

 private:
  struct Carried {
    typename GridType::ConstPtr grid;
    size_t shape;
    Vec3d anchor;
    double weight;
    ActiveBlocks blocks;
  };

  openvdb::Vec3s place(int i, int j, int k, int corner, size_t shape) const {
    return nodes_.at[nodes_.index(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2)) * nodes_.objects + shape];
  }

  /// Whether a carried grid may have something in the cell with this first node.
  bool cellActive(int i, int j, int k) const {
    if (!nodes_.inside(i, j, k) || !nodes_.inside(i + 1, j + 1, k + 1)) return false;
    for (const Carried& c : carried_) {
      openvdb::BBoxd box;
      for (int corner = 0; corner < 8; ++corner)
        box.expand(c.grid->transform().worldToIndex(c.anchor + Vec3d(place(i, j, k, corner, c.shape))));
      // The splines between the nodes overshoot by at most an eighth of the cell; the samples reach a voxel out.
      const Vec3d slack = box.extents() / 8.0 + Vec3d(1.0);
      if (c.blocks.meets({box.min() - slack, box.max() + slack})) return true;
    }
    return false;
  }

  /// The leaf's values; null where nothing turns out to be there.
  Leaf* filled(const openvdb::Coord& origin, const Value& background) const {
    auto leaf = std::make_unique<Leaf>(origin, background);
    const int step = nodes_.step;
    std::vector<openvdb::Vec3s> places(size_t(step) * step * step);
    for (int x = 0; x < kLeaf; x += step)
      for (int y = 0; y < kLeaf; y += step)
        for (int z = 0; z < kLeaf; z += step) {
          const int i = (origin[0] + x) / step, j = (origin[1] + y) / step, k = (origin[2] + z) / step;
          if (!cellActive(i, j, k)) continue;
          std::vector<Value> sum(places.size(), openvdb::zeroVal<Value>());
          std::vector<char> on(places.size(), 0);
          for (const Carried& c : carried_) {
            places_.find(i, j, k, c.shape, places);
            addCell(c, i, j, k, places, sum, on);
          }
          size_t v = 0;
          for (int a = 0; a < step; ++a)
            for (int b = 0; b < step; ++b)
              for (int d = 0; d < step; ++d, ++v)
                if (on[v]) leaf->setValueOn(Leaf::coordToOffset({x + a, y + b, z + d}), sum[v]);
        }
    return leaf->isEmpty() ? nullptr : leaf.release();
  }

  void addCell(const Carried& c, int i, int j, int k, const std::vector<openvdb::Vec3s>& places, std::vector<Value>& sum,
               std::vector<char>& on) const {
    constexpr bool kVector = openvdb::VecTraits<Value>::IsVec;
    const int step = nodes_.step;
    openvdb::Vec3s corner[8];
    if (conserve_ || kVector)
      for (int n = 0; n < 8; ++n) corner[n] = place(i, j, k, n, c.shape);
    const auto accessor = c.grid->getConstAccessor();
    size_t v = 0;
    for (int a = 0; a < step; ++a)
      for (int b = 0; b < step; ++b)
        for (int d = 0; d < step; ++d, ++v) {
          const Vec3d at = c.grid->transform().worldToIndex(c.anchor + Vec3d(places[v]));
          Value value;
          openvdb::tools::BoxSampler::sample(accessor, at, value);
          on[v] |= accessor.isValueOn(openvdb::Coord::round(at));
          double weight = c.weight;
          if (conserve_ || kVector) {
            const Mat3d jacobian = jacobianAt(corner, Vec3d(a, b, d) / step, voxelPerWorld_, step);
            if (conserve_) weight *= std::max(jacobian.det(), 0.0);
            if (kVector) value = turned(rotationOf(jacobian).transpose(), value);
          }
          sum[v] += Value(value * weight);
        }
  }

  const NodeMap& nodes_;
  NodePlaces places_;
  const openvdb::math::Transform& transform_;
  bool conserve_;
  Mat3d voxelPerWorld_;
  std::vector<Carried> carried_;
};

}  // namespace

openvdb::math::Transform::Ptr commonTransform(const std::vector<CarriedGrid>& grids) {
  bool same = true;
  double size = 0, weight = 0;
  for (const CarriedGrid& g : grids) {
    same &= g.grid->transform() == grids[0].grid->transform();
    size += g.weight * std::cbrt(g.grid->transform().voxelVolume()), weight += g.weight;
  }
  return same ? grids[0].grid->transform().copy() : openvdb::math::Transform::createLinearTransform(size / weight);
}

NodeMap nodesOf(const std::vector<CarriedGrid>& grids, const MovingLattice* lattice, const Weights& weights,
                const openvdb::math::Transform& transform) {
  constexpr int kStep = 4;
  const std::optional<Chart> chart = lattice ? std::optional(lattice->chartAt(weights)) : std::nullopt;
  openvdb::BBoxd box;
  for (const CarriedGrid& g : grids) {
    const openvdb::CoordBBox active = g.grid->evalActiveVoxelBoundingBox();
    if (active.empty()) continue;
    openvdb::BBoxd world;
    for (int corner = 0; corner < 8; ++corner)
      world.expand(g.grid->transform().indexToWorld(Vec3d(corner & 1 ? active.max()[0] + 1 : active.min()[0] - 1,
                                                          corner & 2 ? active.max()[1] + 1 : active.min()[1] - 1,
                                                          corner & 4 ? active.max()[2] + 1 : active.min()[2] - 1)));
    if (chart) box.expand(lattice->boxOf(g.shape, world, weights, *chart, transform));
    else box.expand(transform.worldToIndex(world));
  }
  if (box.empty()) return {};
  const openvdb::CoordBBox voxels(openvdb::Coord::floor(box.min()), openvdb::Coord::ceil(box.max()));
  if (chart) return lattice->nodesWithin(voxels, weights, *chart, transform, kStep);
  NodeMap nodes;
  nodes.step = kStep;
  nodes.objects = 1;
  nodes.origin = openvdb::Coord::floor(voxels.min().asVec3d() / kStep) - openvdb::Coord(1);
  nodes.size = openvdb::Coord::ceil(voxels.max().asVec3d() / kStep) + openvdb::Coord(2) - nodes.origin;
  const openvdb::CoordBBox all(nodes.origin, nodes.origin + nodes.size - openvdb::Coord(1));
  nodes.known.assign(size_t(all.volume()), 1);
  nodes.at.resize(nodes.known.size());
  for (auto it = all.begin(); it; ++it)
    nodes.at[nodes.index((*it)[0], (*it)[1], (*it)[2])] =
        openvdb::Vec3s(transform.indexToWorld(kStep * (*it).asVec3d()) - grids[0].anchor);
  return nodes;
}

openvdb::GridBase::Ptr warpGrids(const std::vector<CarriedGrid>& grids, const NodeMap& nodes,
                                 const openvdb::math::Transform& transform, bool conserve) {
  for (const CarriedGrid& g : grids) {
    if (!g.grid || !(g.weight > 0)) continue;
    if (g.grid->isType<FloatGrid>()) return Warper<FloatGrid>(grids, nodes, transform, conserve).run();
    if (g.grid->isType<openvdb::DoubleGrid>()) return Warper<openvdb::DoubleGrid>(grids, nodes, transform, conserve).run();
    if (g.grid->isType<openvdb::Vec3SGrid>()) return Warper<openvdb::Vec3SGrid>(grids, nodes, transform, false).run();
    if (g.grid->isType<openvdb::Vec3DGrid>()) return Warper<openvdb::Vec3DGrid>(grids, nodes, transform, false).run();
    throw InputError("values of the type " + g.grid->valueType() + " cannot be carried");
  }
  throw InputError("there is no grid to carry");
}

}  // namespace slicemorph

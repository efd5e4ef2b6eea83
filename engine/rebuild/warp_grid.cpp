#include "engine/rebuild/warp_grid.h"

#include "engine/blend/node_places.h"
#include "engine/blend/node_stretch.h"
#include "engine/errors.h"
#include "engine/rebuild/active_blocks.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <type_traits>

namespace slicemorph {

namespace {

using openvdb::GridBase;
using Transform = openvdb::math::Transform;
using CarriedTypes = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid,
                                       openvdb::BoolGrid, openvdb::MaskGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                       openvdb::Vec3IGrid>;

/// Frames of more voxels than this along their longest side have nodes twice as far apart.
constexpr int kFineNodesUpTo = 400;

template <typename Value>
constexpr bool kIsVector = openvdb::VecTraits<Value>::IsVec;
/// Numbers between which there are others; the rest are labels, flags and the like.
template <typename Value>
constexpr bool kBlends = std::is_floating_point_v<typename openvdb::VecTraits<Value>::ElementType>;

/// World space, relative to an anchor, to a grid's index space.
class ToIndex {
 public:
  ToIndex(const Transform& transform, const Vec3d& anchor) : transform_(&transform), anchor_(anchor) {
    linear_ = transform.isLinear();
    if (!linear_) return;
    offset_ = transform.worldToIndex(anchor);
    const auto matrix = transform.baseMap()->getAffineMap()->getMat4().inverse().getMat3();
    matrix_ = matrix.transpose();  // OpenVDB multiplies rows from the left
  }
  Vec3d operator()(const Vec3d& place) const {
    return linear_ ? matrix_ * place + offset_ : transform_->worldToIndex(place + anchor_);
  }

 private:
  const Transform* transform_;
  Vec3d anchor_, offset_;
  Mat3d matrix_;
  bool linear_ = false;
};

/// Columns: world-space steps of an index space's axes.
Mat3d worldPerVoxel(const Transform& transform) {
  const Vec3d o = transform.indexToWorld(Vec3d(0.0));
  Mat3d result;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d e(0.0);
    e[axis] = 1;
    const Vec3d column = transform.indexToWorld(e) - o;
    for (int row = 0; row < 3; ++row) result(row, axis) = column[row];
  }
  return result;
}

/// Colours and places do not turn with what they lie on; velocities, normals and all else do.
bool turns(const GridBase& grid) {
  static const std::set<std::string> still{"Cd", "cd", "color", "colour", "rgb", "albedo", "emission", "rest", "uv", "uvw"};
  return grid.getVectorType() != openvdb::VEC_INVARIANT || !still.count(grid.getName());
}

template <typename GridType>
class Warper {
  using Value = typename GridType::ValueType;
  using Tree = typename GridType::TreeType;
  using Leaf = typename Tree::LeafNodeType;
  using Accessor = typename GridType::ConstAccessor;
  using Stored = std::conditional_t<std::is_same_v<Value, bool>, char, Value>;  ///< vectors of bool are bits

 public:
  Warper(const std::vector<CarriedGrid>& grids, const NodeMap& nodes, const Transform& transform, bool conserve)
      : nodes_(nodes), places_(nodes), transform_(transform), like_(first(grids)),
        worldPerVoxel_(worldPerVoxel(transform)), conserve_(conserve && kBlends<Value> && !kIsVector<Value>),
        turn_(kIsVector<Value> && kBlends<Value> && turns(*like_)),
        staggered_(kIsVector<Value> && like_->getGridClass() == openvdb::GRID_STAGGERED) {
    const Mat3d voxelPerWorld = worldPerVoxel_.inverse();
    for (const CarriedGrid& g : grids) {
      const auto grid = openvdb::gridConstPtrCast<GridType>(g.grid);
      if (!grid) throw InputError("grids of different types cannot be blended: " + like_->type() + " and " + g.grid->type());
      carried_.push_back({grid, g.shape, g.weight, ToIndex(grid->transform(), g.anchor), ActiveBlocks(grid->tree()), nullptr});
      if (conserve_ || turn_ || staggered_)
        carried_.back().stretch = std::make_shared<NodeStretch>(nodes, g.shape, voxelPerWorld);
    }
    if (!kBlends<Value> && grids.size() > 1) throw InputError("values of the type " + like_->valueType() + " cannot be blended");
    background_ = blendedBackground();
    band_ = isBand();
  }

  typename GridType::Ptr run() {
    auto result = GridType::create(background_);
    result->setTransform(transform_.copy());
    result->setGridClass(like_->getGridClass());
    result->setVectorType(like_->getVectorType());
    const std::vector<openvdb::Coord> origins =
        leavesWith(nodes_, [this](int i, int j, int k) { return cellActive(i, j, k); });
    std::vector<Leaf*> leaves(origins.size(), nullptr);
    tbb::parallel_for(size_t(0), origins.size(), [&](size_t i) { leaves[i] = filled(origins[i]); });
    for (Leaf* leaf : leaves)
      if (leaf) result->tree().addLeaf(leaf);
    if constexpr (std::is_floating_point_v<Value>)
      if (band_) openvdb::tools::signedFloodFill(result->tree());
    openvdb::tools::prune(result->tree());
    return result;
  }

 private:
  struct Carried {
    typename GridType::ConstPtr grid;
    size_t shape;
    double weight;
    ToIndex toIndex;
    ActiveBlocks blocks;
    std::shared_ptr<const NodeStretch> stretch;  ///< where it is needed
  };

  static typename GridType::ConstPtr first(const std::vector<CarriedGrid>& grids) {
    return openvdb::gridConstPtrCast<GridType>(grids.front().grid);
  }

  Value blendedBackground() const {
    if constexpr (kBlends<Value>) {
      Value sum = like_->background();
      for (const Carried& c : carried_) sum += Value((c.grid->background() - like_->background()) * c.weight);
      return sum;
    } else {
      return carried_.front().grid->background();
    }
  }

  /// A narrow band, whose inside is not active.
  bool isBand() const {
    return like_->getGridClass() == openvdb::GRID_LEVEL_SET && like_->background() > openvdb::zeroVal<Value>() &&
           like_->tree().activeTileCount() == 0;
  }

  /// Whether a carried grid may have something in the cell with this first node.
  bool cellActive(int i, int j, int k) const {
    if (!nodes_.inside(i, j, k) || !nodes_.inside(i + 1, j + 1, k + 1)) return false;
    for (const Carried& c : carried_) {
      openvdb::BBoxd box;
      for (int n = 0; n < 8; ++n) {
        const size_t node = nodes_.index(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2));
        box.expand(c.toIndex(Vec3d(nodes_.at[node * nodes_.objects + c.shape])));
      }
      // The splines between the nodes overshoot by at most an eighth of the cell; the samples reach a voxel out.
      const Vec3d slack = box.extents() / 8.0 + Vec3d(1.0);
      if (c.blocks.meets({box.min() - slack, box.max() + slack})) return true;
    }
    return false;
  }

  struct Cell {
    std::vector<openvdb::Vec3s> places;
    std::vector<Stored> sum;
    std::vector<char> on;
  };

  /// The leaf's values; null where nothing turns out to be there.
  Leaf* filled(const openvdb::Coord& origin) const {
    auto leaf = std::make_unique<Leaf>(origin, background_);
    const int step = nodes_.step;
    const size_t voxels = size_t(step) * step * step;
    Cell cell{std::vector<openvdb::Vec3s>(voxels), {}, {}};
    for (int x = 0; x < kLeaf; x += step)
      for (int y = 0; y < kLeaf; y += step)
        for (int z = 0; z < kLeaf; z += step) {
          const openvdb::Coord node((origin[0] + x) / step, (origin[1] + y) / step, (origin[2] + z) / step);
          if (!cellActive(node[0], node[1], node[2])) continue;
          cell.sum.assign(voxels, backgroundShare());
          cell.on.assign(voxels, 0);
          for (const Carried& c : carried_) addCell(c, node, cell);
          put(cell, {x, y, z}, *leaf);
        }
    return leaf->isEmpty() ? nullptr : leaf.release();
  }

  /// Of what the carried grids' weights lack to 1.
  Value backgroundShare() const {
    if constexpr (kBlends<Value>) {
      double rest = 1;
      for (const Carried& c : carried_) rest -= c.weight;
      return Value(like_->background() * (std::abs(rest) < 1e-12 ? 0 : rest));
    } else {
      return background_;
    }
  }

  void put(const Cell& cell, const openvdb::Coord& at, Leaf& leaf) const {
    size_t v = 0;
    for (int a = 0; a < nodes_.step; ++a)
      for (int b = 0; b < nodes_.step; ++b)
        for (int d = 0; d < nodes_.step; ++d, ++v) {
          const auto offset = Leaf::coordToOffset(at.offsetBy(a, b, d));
          if (cell.on[v]) leaf.setValueOn(offset, cell.sum[v]);
          else if (band_) leaf.setValueOff(offset, cell.sum[v]);
        }
  }

  void addCell(const Carried& c, const openvdb::Coord& node, Cell& cell) const {
    const int step = nodes_.step;
    places_.find(node[0], node[1], node[2], c.shape, cell.places);
    const Accessor accessor = c.grid->getConstAccessor();
    size_t v = 0;
    for (int a = 0; a < step; ++a)
      for (int b = 0; b < step; ++b)
        for (int d = 0; d < step; ++d, ++v) {
          const Vec3d place(cell.places[v]);
          if constexpr (!kBlends<Value>) {
            Value value;
            cell.on[v] = accessor.probeValue(openvdb::Coord::round(c.toIndex(place)), value);
            cell.sum[v] = value;
          } else if (!c.stretch) {
            Value value;
            cell.on[v] |= openvdb::tools::BoxSampler::sample(accessor, c.toIndex(place), value);
            cell.sum[v] += Value(value * c.weight);
          } else {
            const NodeStretch::Local local =
                c.stretch->at(node[0], node[1], node[2], openvdb::Vec3s(float(a), float(b), float(d)) / float(step));
            cell.on[v] |= addStretched(c, accessor, place, local, cell.sum[v]);
          }
        }
  }

  /// Adds a value that the map turns or thins; returns whether there is one.
  bool addStretched(const Carried& c, const Accessor& accessor, const Vec3d& place, const NodeStretch::Local& local,
                    Value& sum) const {
    Value value;
    if constexpr (kIsVector<Value>) {
      if (!staggered_) {
        const bool on = openvdb::tools::BoxSampler::sample(accessor, c.toIndex(place), value);
        sum += Value(turned(local, value) * c.weight);
        return on;
      }
      // Each component lives on the face before the voxel in its direction.
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3d toFace(worldPerVoxel_(0, axis), worldPerVoxel_(1, axis), worldPerVoxel_(2, axis));
        const double size = std::cbrt(double(local.volume));
        const Vec3d face = place - 0.5 * size * (Mat3d(local.rotation) * toFace);
        openvdb::tools::StaggeredBoxSampler::sample(accessor, c.toIndex(face), value);
        sum[axis] += typename Value::ValueType(c.weight * turned(local, value)[axis]);
      }
      return openvdb::tools::BoxSampler::sample(accessor, c.toIndex(place), value);
    } else if constexpr (std::is_floating_point_v<Value>) {
      const bool on = openvdb::tools::BoxSampler::sample(accessor, c.toIndex(place), value);
      sum += Value(value * c.weight * local.volume);
      return on;
    }
    return false;
  }

  Value turned(const NodeStretch::Local& local, const Value& v) const {
    if (!turn_) return v;
    return Value(Mat3d(local.rotation).transpose() * Vec3d(v));
  }

  const NodeMap& nodes_;
  NodePlaces places_;
  const Transform& transform_;
  typename GridType::ConstPtr like_;
  Mat3d worldPerVoxel_;
  bool conserve_, turn_, staggered_, band_ = false;
  std::vector<Carried> carried_;
  Value background_;
};

/// Whether index spaces of two transforms differ by a shift only.
bool sameAxes(const Transform& a, const Transform& b) {
  if (!a.isLinear() || !b.isLinear()) return false;
  const Mat3d x = worldPerVoxel(a), y = worldPerVoxel(b);
  double most = 0, difference = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      most = std::max(most, std::abs(x(i, j)));
      difference = std::max(difference, std::abs(x(i, j) - y(i, j)));
    }
  return difference <= 1e-6 * most;
}

}  // namespace

bool canCarry(const GridBase& grid) {
  return grid.apply<CarriedTypes>([](const auto&) {});
}

bool isBlended(const GridBase& grid) {
  bool blended = false;
  grid.apply<CarriedTypes>([&](const auto& g) { blended = kBlends<typename std::decay_t<decltype(g)>::ValueType>; });
  return blended;
}

Transform::Ptr commonTransform(const std::vector<CarriedGrid>& grids) {
  bool same = true;
  double size = 0, weight = 0;
  for (const CarriedGrid& g : grids) {
    same &= sameAxes(g.grid->transform(), grids[0].grid->transform());
    const openvdb::CoordBBox active = g.grid->evalActiveVoxelBoundingBox();
    const Vec3d middle = active.empty() ? Vec3d(0.0) : active.getCenter();
    size += g.weight * std::cbrt(std::abs(g.grid->transform().voxelVolume(middle))), weight += g.weight;
  }
  return same ? grids[0].grid->transform().copy() : Transform::createLinearTransform(size / weight);
}

openvdb::CoordBBox boxOf(const std::vector<CarriedGrid>& grids, const Carrying& carrying, const Transform& transform) {
  openvdb::BBoxd box;
  for (const CarriedGrid& g : grids) {
    const openvdb::CoordBBox active = g.grid->evalActiveVoxelBoundingBox();
    if (active.empty()) continue;
    openvdb::BBoxd world;
    for (int corner = 0; corner < 8; ++corner)
      world.expand(g.grid->transform().indexToWorld(Vec3d(corner & 1 ? active.max()[0] + 1 : active.min()[0] - 1,
                                                          corner & 2 ? active.max()[1] + 1 : active.min()[1] - 1,
                                                          corner & 4 ? active.max()[2] + 1 : active.min()[2] - 1)));
    if (carrying.lattice) {
      box.expand(carrying.lattice->boxOf(g.shape, world, carrying.pose, transform));
    } else {
      for (int corner = 0; corner < 8; ++corner)
        box.expand(transform.worldToIndex(Vec3d((corner & 1 ? world.max() : world.min())[0],
                                                (corner & 2 ? world.max() : world.min())[1],
                                                (corner & 4 ? world.max() : world.min())[2])));
    }
  }
  if (box.empty()) return {};
  return {openvdb::Coord::floor(box.min()), openvdb::Coord::ceil(box.max())};
}

int carryingStep(const openvdb::CoordBBox& box) {
  return box.dim()[int(box.maxExtent())] > kFineNodesUpTo ? 8 : 4;
}

NodeMap carryingNodes(const openvdb::CoordBBox& box, const Carrying& carrying, const Transform& transform) {
  const int step = carryingStep(box);
  if (carrying.lattice) return carrying.lattice->nodesWithin(box, carrying.pose, transform, step);
  NodeMap nodes;
  nodes.step = step;
  nodes.objects = 1;
  nodes.origin = openvdb::Coord::floor(box.min().asVec3d() / step) - openvdb::Coord(1);
  nodes.size = openvdb::Coord::ceil(box.max().asVec3d() / step) + openvdb::Coord(2) - nodes.origin;
  const openvdb::CoordBBox all(nodes.origin, nodes.origin + nodes.size - openvdb::Coord(1));
  nodes.known.assign(size_t(all.volume()), 1);
  nodes.at.resize(nodes.known.size());
  for (auto it = all.begin(); it; ++it)
    nodes.at[nodes.index((*it)[0], (*it)[1], (*it)[2])] =
        openvdb::Vec3s(transform.indexToWorld(step * (*it).asVec3d()) - carrying.anchor);
  return nodes;
}

GridBase::Ptr warpGrids(const std::vector<CarriedGrid>& grids, const NodeMap& nodes, const Transform& transform,
                        bool conserve) {
  GridBase::Ptr result;
  const bool known = grids.front().grid->apply<CarriedTypes>([&](const auto& grid) {
    result = Warper<std::decay_t<decltype(grid)>>(grids, nodes, transform, conserve).run();
  });
  if (!known) throw InputError("values of the type " + grids.front().grid->valueType() + " cannot be carried");
  return result;
}

}  // namespace slicemorph

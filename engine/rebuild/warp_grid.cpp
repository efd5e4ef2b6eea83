#include "engine/rebuild/warp_grid.h"

#include "engine/blend/node_places.h"
#include "engine/blend/node_stretch.h"
#include "engine/rebuild/active_blocks.h"
#include "engine/rebuild/local_block.h"
#include "engine/volume/surface_colors.h"
#include "slicemorph/errors.h"

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
                                       openvdb::BoolGrid, openvdb::MaskGrid, openvdb::Int32Grid,
                                       openvdb::Int64Grid, openvdb::Vec3IGrid>;

/// Frames of more voxels than this along their longest side have nodes twice as far apart.
constexpr int kFineNodesUpTo = 400;

/// Voxels of a grid that a cell of the in-between may spread over.
constexpr double kMostLocal = 64 * 64 * 64;
/// Voxels of a grid by which the faces of staggered values lie off, at most: half a voxel stretched six
/// times.
constexpr double kStaggeredReach = 3;

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
  static const std::set<std::string> still{"emission", "rest", "uv", "uvw"};
  const bool keeps = isColorName(grid.getName()) || still.count(grid.getName());
  return grid.getVectorType() != openvdb::VEC_INVARIANT || !keeps;
}

/// How one object's grid is found from an in-between.
struct Source {
  size_t shape, object;
  double weight;
  ToIndex toIndex;
  ActiveBlocks blocks;
  std::shared_ptr<const NodeStretch> stretch;  ///< where values turn or thin
};

/// Whether any source may have something in the cell with this first node.
bool cellActive(const NodeMap& nodes, const std::vector<Source>& sources, int i, int j, int k) {
  if (!nodes.inside(i, j, k) || !nodes.inside(i + 1, j + 1, k + 1)) return false;
  for (const Source& s : sources) {
    openvdb::BBoxd box;
    for (int n = 0; n < 8; ++n) {
      const size_t node = nodes.index(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2));
      box.expand(s.toIndex(Vec3d(nodes.at[node * nodes.objects + s.shape])));
    }
    // The splines between the nodes overshoot by at most an eighth of the cell; the samples reach a voxel
    // out.
    const Vec3d slack = box.extents() / 8.0 + Vec3d(1.0);
    if (s.blocks.meets({box.min() - slack, box.max() + slack})) return true;
  }
  return false;
}

/// A leaf's voxels between the nodes of one cell.
struct CellPlaces {
  std::vector<openvdb::Vec3s> world;  ///< relative to the anchor of the object
  std::vector<Vec3d> index;           ///< of the object's grid
  openvdb::BBoxd box;                 ///< of these

  void find(const NodePlaces& places, const openvdb::Coord& node, const Source& source) {
    places.find(node[0], node[1], node[2], source.shape, world);
    index.resize(world.size());
    box = openvdb::BBoxd();
    for (size_t v = 0; v < world.size(); ++v) box.expand(index[v] = source.toIndex(Vec3d(world[v])));
  }
  /// Nodes on both sides of a fold may lie far apart.
  bool torn() const {
    const Vec3d e = box.extents();
    return !(e[0] * e[1] * e[2] < kMostLocal);
  }
};

template <typename GridType>
class Warper {
  using Value = typename GridType::ValueType;
  using Tree = typename GridType::TreeType;
  using Leaf = typename Tree::LeafNodeType;
  using Accessor = typename GridType::ConstAccessor;
  using Stored = std::conditional_t<std::is_same_v<Value, bool>, char, Value>;  ///< vectors of bool are bits
  using Element = typename openvdb::VecTraits<Value>::ElementType;
  using Real = std::conditional_t<std::is_same_v<Element, double>, double, float>;
  static constexpr int kChannels = openvdb::VecTraits<Value>::Size;

 public:
  Warper(const std::vector<CarriedGrid>& grids, const NodeMap& nodes, const LocalWeights& weights,
         const Transform& transform, bool conserve)
      : nodes_(nodes),
        places_(nodes),
        weights_(weights),
        vary_(weights.vary() && kBlends<Value>),
        transform_(transform),
        like_(openvdb::gridConstPtrCast<GridType>(grids.front().grid)),
        worldPerVoxel_(worldPerVoxel(transform)),
        conserve_(conserve && kBlends<Value> && !kIsVector<Value>),
        turn_(kIsVector<Value> && kBlends<Value> && turns(*like_)),
        staggered_(kIsVector<Value> && like_->getGridClass() == openvdb::GRID_STAGGERED),
        smooth_(like_->getGridClass() != openvdb::GRID_LEVEL_SET),
        band_(isBand()),
        color_(isColor()) {
    if (!kBlends<Value> && grids.size() > 1)
      throw InputError("values of the type " + like_->valueType() + " cannot be blended");
    const Mat3d voxelPerWorld = worldPerVoxel_.inverse();
    double rest = 1;
    background_ = like_->background();
    for (const CarriedGrid& g : grids) {
      const auto grid = openvdb::gridConstPtrCast<GridType>(g.grid);
      if (!grid)
        throw InputError("grids of different types cannot be blended: " + like_->type() + " and " +
                         g.grid->type());
      std::shared_ptr<const NodeStretch> stretch;
      if (conserve_ || turn_ || staggered_)
        stretch = std::make_shared<NodeStretch>(nodes, g.shape, voxelPerWorld);
      grids_.push_back(grid);
      sources_.push_back({g.shape, g.object, g.weight, ToIndex(grid->transform(), g.anchor),
                          ActiveBlocks(grid->tree()), stretch});
      rest -= g.weight;
      if constexpr (kBlends<Value>)
        background_ += Value((grid->background() - like_->background()) * g.weight);
    }
    if constexpr (kBlends<Value>) missing_ = Value(like_->background() * (std::abs(rest) < 1e-12 ? 0 : rest));
  }

  typename GridType::Ptr run() {
    auto result = GridType::create(background_);
    result->setTransform(transform_.copy());
    result->setGridClass(like_->getGridClass());
    result->setVectorType(like_->getVectorType());
    const std::vector<openvdb::Coord> origins =
        leavesWith(nodes_, [this](int i, int j, int k) { return cellActive(nodes_, sources_, i, j, k); });
    std::vector<Leaf*> leaves(origins.size(), nullptr);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, origins.size()),
                      [&](const tbb::blocked_range<size_t>& range) {
                        Scratch scratch(*this);
                        for (size_t i = range.begin(); i != range.end(); ++i)
                          leaves[i] = filled(origins[i], scratch);
                      });
    for (Leaf* leaf : leaves)
      if (leaf) result->tree().addLeaf(leaf);
    if constexpr (std::is_same_v<GridType, FloatGrid>)
      if (band_) openvdb::tools::signedFloodFill(result->tree());
    result->tree().prune();
    return result;
  }

 private:
  /// What one thread works with.
  struct Scratch {
    explicit Scratch(const Warper& warper) : sum(warper.cellSize()), on(sum.size()) {
      places.world.resize(sum.size());
      for (const auto& grid : warper.grids_) accessors.push_back(grid->getConstAccessor());
    }
    std::vector<Accessor> accessors;
    CellPlaces places;
    LocalBlock<Real> block;
    std::vector<Stored> sum;
    std::vector<char> on;
    std::vector<double> mass;      ///< of colours: per voxel, the weights that are in the sum
    std::vector<Weights> weights;  ///< per voxel, where they vary
    std::vector<std::vector<openvdb::Vec3s>> regionPlaces;  ///< per shape
  };

  size_t cellSize() const { return size_t(nodes_.step) * size_t(nodes_.step) * size_t(nodes_.step); }

  /// A narrow band, whose inside is not active.
  bool isBand() const {
    if constexpr (std::is_same_v<GridType, FloatGrid>)
      return like_->getGridClass() == openvdb::GRID_LEVEL_SET && like_->background() > 0 &&
             like_->tree().activeTileCount() == 0;
    return false;
  }

  bool isColor() const {
    if constexpr (kIsVector<Value> && kBlends<Value>) return isColorName(like_->getName());
    return false;
  }

  /// The objects' weights at a cell's voxels.
  void findWeights(const openvdb::Coord& node, Scratch& scratch) const {
    if (!vary_) return;
    scratch.regionPlaces.resize(nodes_.objects);
    const std::vector<size_t> shapes = weights_.regionObjects();
    for (size_t shape : shapes) {
      scratch.regionPlaces[shape].resize(cellSize());
      places_.find(node[0], node[1], node[2], shape, scratch.regionPlaces[shape]);
    }
    std::vector<openvdb::Vec3s> at(nodes_.objects, openvdb::Vec3s(0.f));
    scratch.weights.assign(cellSize(), Weights(weights_.whole().size()));
    for (size_t v = 0; v < scratch.weights.size(); ++v) {
      for (size_t shape : shapes) at[shape] = scratch.regionPlaces[shape][v];
      weights_.find(at.data(), scratch.weights[v].data());
    }
  }

  double weightOf(const Source& source, const Scratch& scratch, size_t v) const {
    return vary_ ? scratch.weights[v][source.object] : source.weight;
  }

  /// What a sum lacks, where the weights of its grids do not sum to 1.
  Value missingAt(const Scratch& scratch, size_t v) const {
    if constexpr (kBlends<Value>) {
      if (!vary_) return missing_;
      double rest = 1;
      for (const Source& s : sources_) rest -= scratch.weights[v][s.object];
      return Value(like_->background() * (std::abs(rest) < 1e-12 ? 0 : rest));
    }
    return missing_;
  }

  /// The leaf's values; null where nothing turns out to be there.
  Leaf* filled(const openvdb::Coord& origin, Scratch& scratch) const {
    auto leaf = std::make_unique<Leaf>(origin, background_);
    const int step = nodes_.step;
    for (int x = 0; x < kLeaf; x += step)
      for (int y = 0; y < kLeaf; y += step)
        for (int z = 0; z < kLeaf; z += step) {
          const openvdb::Coord node((origin[0] + x) / step, (origin[1] + y) / step, (origin[2] + z) / step);
          if (!cellActive(nodes_, sources_, node[0], node[1], node[2])) continue;
          findWeights(node, scratch);
          for (size_t v = 0; v < scratch.sum.size(); ++v)
            scratch.sum[v] = color_ ? openvdb::zeroVal<Value>() : missingAt(scratch, v);
          std::fill(scratch.on.begin(), scratch.on.end(), 0);
          scratch.mass.assign(color_ ? scratch.sum.size() : 0, 0.0);
          for (size_t s = 0; s < sources_.size(); ++s)
            color_ ? addColors(s, node, scratch) : addCell(s, node, scratch);
          finishColors(scratch);
          put(scratch, {x, y, z}, *leaf);
        }
    return leaf->isEmpty() ? nullptr : leaf.release();
  }

  void put(const Scratch& scratch, const openvdb::Coord& at, Leaf& leaf) const {
    size_t v = 0;
    for (int a = 0; a < nodes_.step; ++a)
      for (int b = 0; b < nodes_.step; ++b)
        for (int d = 0; d < nodes_.step; ++d, ++v) {
          const openvdb::Index offset = Leaf::coordToOffset(at.offsetBy(a, b, d));
          if (scratch.on[v])
            leaf.setValueOn(offset, scratch.sum[v]);
          else if (band_)
            leaf.setValueOff(offset, scratch.sum[v]);
        }
  }

  /// Adds what is active, by its weight.
  void addColors(size_t s, const openvdb::Coord& node, Scratch& scratch) const {
    if constexpr (kIsVector<Value> && kBlends<Value>) {
      const Source& source = sources_[s];
      scratch.places.find(places_, node, source);
      if (scratch.places.torn()) return;
      scratch.block.template fill<GridType>(scratch.accessors[s], scratch.places.box);
      if (!scratch.block.anyActive()) return;
      for (size_t v = 0; v < scratch.sum.size(); ++v) {
        Real value[3];
        const double share = double(scratch.block.linearAmongActive(scratch.places.index[v], value));
        const double weight = weightOf(source, scratch, v) * share;
        if (!(weight > 0)) continue;
        scratch.sum[v] +=
            Value(Element(value[0] * weight), Element(value[1] * weight), Element(value[2] * weight));
        scratch.mass[v] += weight;
        scratch.on[v] = 1;
      }
    }
  }

  void finishColors(Scratch& scratch) const {
    if constexpr (kIsVector<Value> && kBlends<Value>)
      for (size_t v = 0; v < scratch.mass.size(); ++v)
        if (scratch.on[v]) scratch.sum[v] = Value(scratch.sum[v] * (1 / scratch.mass[v]));
  }

  void addCell(size_t s, const openvdb::Coord& node, Scratch& scratch) const {
    const Source& source = sources_[s];
    scratch.places.find(places_, node, source);
    if (scratch.places.torn()) return;
    if constexpr (!kBlends<Value>) {
      for (size_t v = 0; v < scratch.sum.size(); ++v) {
        Value value{};
        scratch.on[v] =
            scratch.accessors[s].probeValue(openvdb::Coord::round(scratch.places.index[v]), value);
        scratch.sum[v] = value;
      }
    } else {
      openvdb::BBoxd box = scratch.places.box;
      if (staggered_) box.min() -= Vec3d(kStaggeredReach + 0.5), box.max() += Vec3d(kStaggeredReach + 0.5);
      scratch.block.template fill<GridType>(scratch.accessors[s], box);
      if (!scratch.block.anyActive() && zeroOutside(s)) return;
      if (scratch.block.uniform() && !source.stretch && !vary_) {
        const Value value(sampled(scratch.block, scratch.places.index[0]) * source.weight);
        for (Stored& sum : scratch.sum) sum += value;
        std::fill(scratch.on.begin(), scratch.on.end(), 1);
        return;
      }
      for (size_t v = 0; v < scratch.sum.size(); ++v) {
        const bool on = scratch.block.active(scratch.places.index[v]);
        scratch.on[v] |= on;
        if (on || !zeroOutside(s)) scratch.sum[v] += value(source, node, scratch, v);
      }
    }
  }

  /// Whether there is nothing where a grid is not active.
  bool zeroOutside(size_t s) const { return !band_ && grids_[s]->background() == openvdb::zeroVal<Value>(); }

  Value value(const Source& source, const openvdb::Coord& node, const Scratch& scratch, size_t v) const {
    const Vec3d& at = scratch.places.index[v];
    const double weight = weightOf(source, scratch, v);
    if (!source.stretch) return Value(sampled(scratch.block, at) * weight);
    const int step = nodes_.step, n = int(v);
    const openvdb::Vec3s fraction(float(n / (step * step)), float(n / step % step), float(n % step));
    const NodeStretch::Local local = source.stretch->at(node[0], node[1], node[2], fraction / float(step));
    if constexpr (!kIsVector<Value>) {
      return Value(sampled(scratch.block, at) * (weight * double(local.volume)));
    } else {
      if (!staggered_) return Value(turned(local, sampled(scratch.block, at)) * weight);
      // Each component lives on the face before the voxel in its direction, in the in-between as in the grid.
      Value result;
      const double size = std::cbrt(double(local.volume));
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3d toFace(worldPerVoxel_(0, axis), worldPerVoxel_(1, axis), worldPerVoxel_(2, axis));
        Vec3d face =
            source.toIndex(Vec3d(scratch.places.world[v]) - 0.5 * size * (Mat3d(local.rotation) * toFace));
        for (int c = 0; c < 3; ++c)
          face[c] = std::clamp(face[c], scratch.places.box.min()[c] - kStaggeredReach,
                               scratch.places.box.max()[c] + kStaggeredReach);
        Value whole;
        for (int c = 0; c < 3; ++c) {
          Vec3d own = face;
          own[c] += 0.5;
          whole[c] = Element(scratch.block.cubic(own, c));
        }
        result[axis] = Element(turned(local, whole)[axis] * weight);
      }
      return result;
    }
  }

  Value sampled(const LocalBlock<Real>& block, const Vec3d& at) const {
    if constexpr (kIsVector<Value>) {
      Value value;
      for (int c = 0; c < kChannels; ++c)
        value[c] = Element(smooth_ ? block.cubic(at, c) : block.linear(at, c));
      return value;
    } else {
      return Value(smooth_ ? block.cubic(at, 0) : block.linear(at, 0));
    }
  }

  Value turned(const NodeStretch::Local& local, const Value& v) const {
    return turn_ ? Value(Mat3d(local.rotation).transpose() * Vec3d(v)) : v;
  }

  const NodeMap& nodes_;
  NodePlaces places_;
  const LocalWeights& weights_;
  bool vary_;
  const Transform& transform_;
  typename GridType::ConstPtr like_;
  Mat3d worldPerVoxel_;
  bool conserve_, turn_, staggered_;
  bool smooth_;  ///< splines; jumps of dense level sets to their far values would ring
  bool band_, color_;
  std::vector<typename GridType::ConstPtr> grids_;
  std::vector<Source> sources_;
  Value background_;
  Value missing_{};  ///< of what the weights lack to 1
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
  grid.apply<CarriedTypes>(
      [&](const auto& g) { blended = kBlends<typename std::decay_t<decltype(g)>::ValueType>; });
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
  if (same) return grids[0].grid->transform().copy();
  // Regions may take what counts nowhere else.
  return Transform::createLinearTransform(
      weight > 0 ? size / weight : std::cbrt(std::abs(grids[0].grid->transform().voxelVolume())));
}

openvdb::CoordBBox boxOf(const std::vector<CarriedGrid>& grids, const Carrying& carrying,
                         const Transform& transform) {
  openvdb::BBoxd box;
  for (const CarriedGrid& g : grids) {
    const openvdb::CoordBBox active = g.grid->evalActiveVoxelBoundingBox();
    if (active.empty()) continue;
    const openvdb::BBoxd reach(active.min().asVec3d() - Vec3d(1.0), active.max().asVec3d() + Vec3d(1.0));
    const openvdb::BBoxd world = g.grid->transform().indexToWorld(reach);
    box.expand(carrying.lattice ? carrying.lattice->boxOf(g.shape, world, carrying.pose, transform)
                                : transform.worldToIndex(world));
  }
  if (box.empty()) return {};
  return {openvdb::Coord::floor(box.min()), openvdb::Coord::ceil(box.max())};
}

int carryingStep(const openvdb::CoordBBox& box) {
  return box.dim()[int(box.maxExtent())] > kFineNodesUpTo ? 8 : 4;
}

NodeMap carryingNodes(const openvdb::CoordBBox& box, const Carrying& carrying, const Transform& transform,
                      int step) {
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

GridBase::Ptr warpGrids(const std::vector<CarriedGrid>& grids, const NodeMap& nodes,
                        const LocalWeights& weights, const Transform& transform, bool conserve) {
  GridBase::Ptr result;
  const bool known = grids.front().grid->apply<CarriedTypes>([&](const auto& grid) {
    result = Warper<std::decay_t<decltype(grid)>>(grids, nodes, weights, transform, conserve).run();
  });
  if (!known)
    throw InputError("values of the type " + grids.front().grid->valueType() + " cannot be carried");
  return result;
}

}  // namespace slicemorph

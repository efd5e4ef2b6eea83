#include "engine/rebuild/warp_grid.h"

#include "engine/blend/node_positions.h"
#include "engine/blend/node_stretch.h"
#include "engine/rebuild/typed_grids.h"
#include "engine/volume/surface_colors.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

namespace slicemorph {

namespace {

using openvdb::GridBase;
using Transform = openvdb::math::Transform;

/// Boxes with a longer side than this, in voxels, get nodes 8 instead of 4 voxels apart, as in
/// nodeStepOf of in_between.cpp.
constexpr int kFineNodesUpTo = 400;

/// Largest volume, in voxels of an input grid, that the image of one cell of 4^3 or 8^3 voxels may cover:
/// eight times stretched along every axis, or more. A larger one is taken for a fold and left out.
constexpr double kMostLocal = 64 * 64 * 64;
/// Largest distance, in voxels of an input grid, between the centre of a staggered voxel and its faces: half
/// a voxel, stretched six times.
constexpr double kStaggeredReach = 3;

/// World position, relative to an anchor, to a grid's index space.
class ToIndex {
 public:
  ToIndex(const Transform& transform, const Vec3d& anchor) : transform_(&transform), anchor_(anchor) {
    linear_ = transform.isLinear();
    if (!linear_) return;
    offset_ = transform.worldToIndex(anchor);
    const auto matrix = transform.baseMap()->getAffineMap()->getMat4().inverse().getMat3();
    matrix_ = matrix.transpose();  // OpenVDB multiplies rows from the left
  }
  Vec3d operator()(const Vec3d& position) const {
    return linear_ ? matrix_ * position + offset_ : transform_->worldToIndex(position + anchor_);
  }

 private:
  const Transform* transform_;
  Vec3d anchor_, offset_;
  Mat3d matrix_;
  bool linear_ = false;
};

/// Jacobian of index to world space; its columns are the world vectors of the index axes.
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

/// Colours and texture coordinates do not turn with the surface; velocities, normals and everything else do.
bool turns(const GridBase& grid) {
  static const std::set<std::string> still{"emission", "rest", "uv", "uvw"};
  const bool keeps = isColorName(grid.getName()) || still.count(grid.getName());
  return grid.getVectorType() != openvdb::VEC_INVARIANT || !keeps;
}

/// One input grid and how to look it up from the in-between.
struct Source {
  size_t shape, object;
  double weight;
  ToIndex toIndex;
  ActiveBlocks blocks;
  std::shared_ptr<const NodeStretch> stretch;  ///< only where values turn or are conserved
};

/// Whether any source may have active voxels in the cell with this first node.
bool cellActive(const NodeMap& nodes, const std::vector<Source>& sources, int i, int j, int k) {
  if (!nodes.inside(i, j, k) || !nodes.inside(i + 1, j + 1, k + 1)) return false;
  for (const Source& s : sources) {
    openvdb::BBoxd box;
    for (int n = 0; n < 8; ++n) {
      const size_t node = nodes.index(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2));
      box.expand(s.toIndex(Vec3d(nodes.at[node * nodes.objects + s.shape])));
    }
    // Splines between the nodes overshoot by at most an eighth of the cell; interpolation reads
    // one voxel further.
    const Vec3d slack = box.extents() / 8.0 + Vec3d(1.0);
    if (s.blocks.meets({box.min() - slack, box.max() + slack})) return true;
  }
  return false;
}

/// Positions of the voxels of one cell on one object.
struct CellPositions {
  std::vector<openvdb::Vec3s> world;  ///< world units, relative to the object's anchor
  std::vector<Vec3d> index;           ///< index space of the object's grid
  openvdb::BBoxd box;                 ///< bounds of `index`

  void find(const NodePositions& positions, const openvdb::Coord& node, const Source& source) {
    positions.find(node[0], node[1], node[2], source.shape, world);
    index.resize(world.size());
    box = openvdb::BBoxd();
    for (size_t v = 0; v < world.size(); ++v) box.expand(index[v] = source.toIndex(Vec3d(world[v])));
  }
  /// Whether the cell spans a fold: its nodes then lie far apart on the object.
  bool torn() const {
    const Vec3d e = box.extents();
    return !(e[0] * e[1] * e[2] < kMostLocal);
  }
};

/// Rounding errors of a sum of weights count as 0.
double restOf(double rest) { return std::abs(rest) < 1e-12 ? 0 : rest; }

/// Whether the grid is a narrow-band level set, without active tiles inside.
bool isBand(const GridBase& grid) {
  const auto* scalars = dynamic_cast<const FloatGrid*>(&grid);
  return scalars && grid.getGridClass() == openvdb::GRID_LEVEL_SET && scalars->background() > 0 &&
         scalars->tree().activeTileCount() == 0;
}

/// Blends grids of numbers. `Real`: float or double, as the grids have it.
template <typename Real>
class Blender {
  using Numbers = NumberGrids<Real>;
  using Channels = typename Numbers::Channels;

 public:
  Blender(std::unique_ptr<Numbers> numbers, const std::vector<CarriedGrid>& grids, const NodeMap& nodes,
          const LocalWeights& weights, const Transform& transform, bool conserve)
      : numbers_(std::move(numbers)),
        channels_(numbers_->channels()),
        nodes_(nodes),
        positions_(nodes),
        weights_(weights),
        vary_(weights.vary()),
        prototype_(*grids.front().grid),
        worldPerVoxel_(worldPerVoxel(transform)),
        conserve_(conserve && channels_ == 1),
        turn_(channels_ == 3 && turns(prototype_)),
        staggered_(channels_ == 3 && prototype_.getGridClass() == openvdb::GRID_STAGGERED),
        smooth_(prototype_.getGridClass() != openvdb::GRID_LEVEL_SET),
        band_(isBand(prototype_)),
        color_(channels_ == 3 && isColorName(prototype_.getName())) {
    const Mat3d voxelPerWorld = worldPerVoxel_.inverse();
    const Channels first = numbers_->background(0);
    double rest = 1;
    background_ = first;
    for (size_t s = 0; s < grids.size(); ++s) {
      const CarriedGrid& g = grids[s];
      std::shared_ptr<const NodeStretch> stretch;
      if (conserve_ || turn_ || staggered_)
        stretch = std::make_shared<NodeStretch>(nodes, g.shape, voxelPerWorld);
      sources_.push_back({g.shape, g.object, g.weight, ToIndex(g.grid->transform(), g.anchor),
                          numbers_->activeBlocks(s), stretch});
      rest -= g.weight;
      const Channels own = numbers_->background(s);
      for (int c = 0; c < channels_; ++c) background_[c] += Real(Real(own[c] - first[c]) * g.weight);
      zeroOutside_.push_back(!band_ && own == Channels{});
    }
    for (int c = 0; c < channels_; ++c) missing_[c] = Real(first[c] * restOf(rest));
  }

  GridBase::Ptr run() {
    const std::vector<openvdb::Coord> origins =
        leavesWith(nodes_, [this](int i, int j, int k) { return cellActive(nodes_, sources_, i, j, k); });
    numbers_->beginLeaves(origins.size(), background_);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, origins.size()),
                      [&](const tbb::blocked_range<size_t>& range) {
                        Scratch scratch(*this);
                        for (size_t i = range.begin(); i != range.end(); ++i) {
                          fillLeaf(origins[i], scratch);
                          numbers_->setLeaf(i, scratch.leaf);
                        }
                      });
    return numbers_->endLeaves(band_);
  }

 private:
  static constexpr size_t kLeafVoxels = size_t(kLeaf) * kLeaf * kLeaf;

  /// Buffers of one task.
  struct Scratch {
    explicit Scratch(const Blender& blender) : sum(blender.cellSize()), on(sum.size()) {
      positions.world.resize(sum.size());
      for (size_t s = 0; s < blender.sources_.size(); ++s) readers.push_back(blender.numbers_->reader(s));
      leaf.values.resize(kLeafVoxels * size_t(blender.channels_));
      leaf.states.resize(kLeafVoxels);
    }
    std::vector<std::unique_ptr<typename Numbers::Reader>> readers;
    CellPositions positions;
    LocalBlock<Real> block;
    LeafValues<Real> leaf;
    std::vector<Channels> sum;
    std::vector<char> on;
    std::vector<double> mass;      ///< for colours: per voxel, sum of the weights so far
    std::vector<Weights> weights;  ///< per voxel, where they vary
    std::vector<std::vector<openvdb::Vec3s>> regionPositions;  ///< per shape
  };

  size_t cellSize() const { return size_t(nodes_.step) * size_t(nodes_.step) * size_t(nodes_.step); }

  /// Computes the objects' weights at the voxels of a cell, where they vary.
  void findWeights(const openvdb::Coord& node, Scratch& scratch) const {
    if (!vary_) return;
    scratch.regionPositions.resize(nodes_.objects);
    const std::vector<size_t> shapes = weights_.regionObjects();
    for (size_t shape : shapes) {
      scratch.regionPositions[shape].resize(cellSize());
      positions_.find(node[0], node[1], node[2], shape, scratch.regionPositions[shape]);
    }
    std::vector<openvdb::Vec3s> at(nodes_.objects, openvdb::Vec3s(0.f));
    scratch.weights.assign(cellSize(), Weights(weights_.whole().size()));
    for (size_t v = 0; v < scratch.weights.size(); ++v) {
      for (size_t shape : shapes) at[shape] = scratch.regionPositions[shape][v];
      weights_.find(at.data(), scratch.weights[v].data());
    }
  }

  double weightOf(const Source& source, const Scratch& scratch, size_t v) const {
    return vary_ ? scratch.weights[v][source.object] : source.weight;
  }

  /// The first grid's background, weighted by what the grids' weights lack to a sum of 1.
  Channels missingAt(const Scratch& scratch, size_t v) const {
    if (!vary_) return missing_;
    double rest = 1;
    for (const Source& s : sources_) rest -= scratch.weights[v][s.object];
    const Channels first = numbers_->background(0);
    Channels missing{};
    for (int c = 0; c < channels_; ++c) missing[c] = Real(first[c] * restOf(rest));
    return missing;
  }

  void fillLeaf(const openvdb::Coord& origin, Scratch& scratch) const {
    scratch.leaf.origin = origin;
    std::fill(scratch.leaf.states.begin(), scratch.leaf.states.end(), LeafValues<Real>::kUntouched);
    const int step = nodes_.step;
    for (int x = 0; x < kLeaf; x += step)
      for (int y = 0; y < kLeaf; y += step)
        for (int z = 0; z < kLeaf; z += step) {
          const openvdb::Coord node((origin[0] + x) / step, (origin[1] + y) / step, (origin[2] + z) / step);
          if (!cellActive(nodes_, sources_, node[0], node[1], node[2])) continue;
          findWeights(node, scratch);
          for (size_t v = 0; v < scratch.sum.size(); ++v)
            scratch.sum[v] = color_ ? Channels{} : missingAt(scratch, v);
          std::fill(scratch.on.begin(), scratch.on.end(), 0);
          scratch.mass.assign(color_ ? scratch.sum.size() : 0, 0.0);
          for (size_t s = 0; s < sources_.size(); ++s)
            color_ ? addColors(s, node, scratch) : addCell(s, node, scratch);
          finishColors(scratch);
          put({x, y, z}, scratch);
        }
  }

  void put(const openvdb::Coord& at, Scratch& scratch) const {
    size_t v = 0;
    for (int a = 0; a < nodes_.step; ++a)
      for (int b = 0; b < nodes_.step; ++b)
        for (int d = 0; d < nodes_.step; ++d, ++v) {
          if (!scratch.on[v] && !band_) continue;
          const size_t n = size_t(((at[0] + a) * kLeaf + at[1] + b) * kLeaf + at[2] + d);
          for (int c = 0; c < channels_; ++c)
            scratch.leaf.values[size_t(c) * kLeafVoxels + n] = scratch.sum[v][size_t(c)];
          scratch.leaf.states[n] = scratch.on[v] ? LeafValues<Real>::kOn : LeafValues<Real>::kOff;
        }
  }

  /// Adds the active voxels' colours by their weights.
  void addColors(size_t s, const openvdb::Coord& node, Scratch& scratch) const {
    const Source& source = sources_[s];
    scratch.positions.find(positions_, node, source);
    if (scratch.positions.torn()) return;
    scratch.readers[s]->fill(scratch.block, scratch.positions.box);
    if (!scratch.block.anyActive()) return;
    for (size_t v = 0; v < scratch.sum.size(); ++v) {
      Real value[3];
      const double share = double(scratch.block.linearAmongActive(scratch.positions.index[v], value));
      const double weight = weightOf(source, scratch, v) * share;
      if (!(weight > 0)) continue;
      for (int c = 0; c < 3; ++c) scratch.sum[v][size_t(c)] += Real(value[c] * weight);
      scratch.mass[v] += weight;
      scratch.on[v] = 1;
    }
  }

  void finishColors(Scratch& scratch) const {
    for (size_t v = 0; v < scratch.mass.size(); ++v)
      if (scratch.on[v])
        for (Real& channel : scratch.sum[v]) channel = Real(channel * (1 / scratch.mass[v]));
  }

  void addCell(size_t s, const openvdb::Coord& node, Scratch& scratch) const {
    const Source& source = sources_[s];
    scratch.positions.find(positions_, node, source);
    if (scratch.positions.torn()) return;
    openvdb::BBoxd box = scratch.positions.box;
    if (staggered_) box.min() -= Vec3d(kStaggeredReach + 0.5), box.max() += Vec3d(kStaggeredReach + 0.5);
    scratch.readers[s]->fill(scratch.block, box);
    if (!scratch.block.anyActive() && zeroOutside_[s]) return;
    if (scratch.block.uniform() && !source.stretch && !vary_) {
      const Channels value = weighted(sampled(scratch.block, scratch.positions.index[0]), source.weight);
      for (Channels& sum : scratch.sum) add(value, sum);
      std::fill(scratch.on.begin(), scratch.on.end(), 1);
      return;
    }
    for (size_t v = 0; v < scratch.sum.size(); ++v) {
      const bool on = scratch.block.active(scratch.positions.index[v]);
      scratch.on[v] |= on;
      if (on || !zeroOutside_[s]) add(value(source, node, scratch, v), scratch.sum[v]);
    }
  }

  Channels value(const Source& source, const openvdb::Coord& node, const Scratch& scratch, size_t v) const {
    const Vec3d& at = scratch.positions.index[v];
    const double weight = weightOf(source, scratch, v);
    if (!source.stretch) return weighted(sampled(scratch.block, at), weight);
    const int step = nodes_.step, n = int(v);
    const openvdb::Vec3s fraction(float(n / (step * step)), float(n / step % step), float(n % step));
    const NodeStretch::Local local = source.stretch->at(node[0], node[1], node[2], fraction / float(step));
    if (channels_ == 1) return weighted(sampled(scratch.block, at), weight * double(local.volume));
    if (staggered_) return staggeredValue(source, local, scratch, v, weight);
    return weighted(turned(local, sampled(scratch.block, at)), weight);
  }

  /// Each component is located on the face before the voxel along its axis, on the in-between as in the grid.
  Channels staggeredValue(const Source& source, const NodeStretch::Local& local, const Scratch& scratch,
                          size_t v, double weight) const {
    Channels result{};
    const double size = std::cbrt(double(local.volume));
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3d toFace(worldPerVoxel_(0, axis), worldPerVoxel_(1, axis), worldPerVoxel_(2, axis));
      Vec3d face =
          source.toIndex(Vec3d(scratch.positions.world[v]) - 0.5 * size * (Mat3d(local.rotation) * toFace));
      for (int c = 0; c < 3; ++c)
        face[c] = std::clamp(face[c], scratch.positions.box.min()[c] - kStaggeredReach,
                             scratch.positions.box.max()[c] + kStaggeredReach);
      Channels whole{};
      for (int c = 0; c < 3; ++c) {
        Vec3d own = face;
        own[c] += 0.5;
        whole[size_t(c)] = scratch.block.cubic(own, c);
      }
      result[size_t(axis)] = Real(turned(local, whole)[size_t(axis)] * weight);
    }
    return result;
  }

  Channels sampled(const LocalBlock<Real>& block, const Vec3d& at) const {
    Channels value{};
    for (int c = 0; c < channels_; ++c) value[size_t(c)] = smooth_ ? block.cubic(at, c) : block.linear(at, c);
    return value;
  }

  Channels turned(const NodeStretch::Local& local, const Channels& v) const {
    if (!turn_) return v;
    const Vec3d t = Mat3d(local.rotation).transpose() * Vec3d(v[0], v[1], v[2]);
    return {Real(t[0]), Real(t[1]), Real(t[2])};
  }

  Channels weighted(Channels value, double weight) const {
    for (int c = 0; c < channels_; ++c) value[size_t(c)] = Real(value[size_t(c)] * weight);
    return value;
  }

  void add(const Channels& value, Channels& sum) const {
    for (int c = 0; c < channels_; ++c) sum[size_t(c)] += value[size_t(c)];
  }

  std::unique_ptr<Numbers> numbers_;
  int channels_;
  const NodeMap& nodes_;
  NodePositions positions_;
  const LocalWeights& weights_;
  bool vary_;
  const GridBase& prototype_;
  Mat3d worldPerVoxel_;
  bool conserve_, turn_, staggered_;
  bool smooth_;  ///< splines; not for level sets: dense ones jump to a far value, where a spline would ring
  bool band_, color_;
  std::vector<Source> sources_;
  std::vector<char> zeroOutside_;  ///< per source: inactive voxels contribute nothing
  Channels background_{};
  Channels missing_{};  ///< background of weight 1 - sum of weights
};

/// For values that cannot be averaged: the nearest voxel of the only grid.
GridBase::Ptr nearestInBetween(const CarriedGrid& carried, const NodeMap& nodes) {
  std::unique_ptr<ActiveBlocks> blocks = nearestActiveBlocks(*carried.grid);
  if (!blocks) throw InputError("values of the type " + carried.grid->valueType() + " cannot be carried");
  const std::vector<Source> sources{{carried.shape, carried.object, carried.weight,
                                     ToIndex(carried.grid->transform(), carried.anchor), std::move(*blocks),
                                     nullptr}};
  const NodePositions nodePositions(nodes);
  const int step = nodes.step;
  const std::vector<openvdb::Coord> origins =
      leavesWith(nodes, [&](int i, int j, int k) { return cellActive(nodes, sources, i, j, k); });
  return nearestValues(*carried.grid, origins, [&](const openvdb::Coord& origin, const CellVisitor& cell) {
    CellPositions positions;
    positions.world.resize(size_t(step) * size_t(step) * size_t(step));
    for (int x = 0; x < kLeaf; x += step)
      for (int y = 0; y < kLeaf; y += step)
        for (int z = 0; z < kLeaf; z += step) {
          const openvdb::Coord node((origin[0] + x) / step, (origin[1] + y) / step, (origin[2] + z) / step);
          if (!cellActive(nodes, sources, node[0], node[1], node[2])) continue;
          positions.find(nodePositions, node, sources[0]);
          if (!positions.torn()) cell(positions.index, {x, y, z}, step);
        }
  });
}

/// Whether two index spaces differ by a translation only.
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
  return isBlended(grid) || grid.apply<NearestTypes>([](const auto&) {});
}

bool isBlended(const GridBase& grid) {
  return grid.apply<BlendedTypes>([](const auto&) {});
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
  // A grid may have weight 0 except within regions.
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
    box.expand(carrying.lattice ? carrying.lattice->boxOf(g.shape, world, *carrying.pose, transform)
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
  if (carrying.lattice) return carrying.lattice->nodesWithin(box, *carrying.pose, transform, step);
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
  const GridBase& prototype = *grids.front().grid;
  std::vector<GridBase::ConstPtr> own;
  own.reserve(grids.size());
  for (const CarriedGrid& g : grids) own.push_back(g.grid);
  GridBase::Ptr result;
  if (auto floats = numberGrids<float>(own)) {
    result = Blender<float>(std::move(floats), grids, nodes, weights, transform, conserve).run();
  } else if (auto doubles = numberGrids<double>(own)) {
    result = Blender<double>(std::move(doubles), grids, nodes, weights, transform, conserve).run();
  } else {
    if (grids.size() > 1)
      throw InputError("values of the type " + prototype.valueType() + " cannot be blended");
    result = nearestInBetween(grids.front(), nodes);
  }
  result->setTransform(transform.copy());
  result->setGridClass(prototype.getGridClass());
  result->setVectorType(prototype.getVectorType());
  return result;
}

}  // namespace slicemorph

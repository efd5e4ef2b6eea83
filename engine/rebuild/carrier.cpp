#include "engine/rebuild/carrier.h"

#include "engine/blend/node_places.h"
#include "engine/errors.h"
#include "engine/rebuild/warp_image.h"
#include "engine/rebuild/warp_labels.h"
#include "engine/volume/resample_image.h"

#include <openvdb/tools/Morphology.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

using openvdb::GridBase;
using Transform = openvdb::math::Transform;

/// Weights nearer to 1 than this are 1.
constexpr double kWhole = 1e-9;
/// Node maps that are kept; a file has mostly one transform.
constexpr size_t kKeptMaps = 3;
/// Voxels around what moves in which velocities are found.
constexpr int kMostReach = 24;

openvdb::Vec3STree::Ptr topologyOf(const GridBase& where) {
  openvdb::Vec3STree::Ptr tree;
  using Types = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::BoolGrid, openvdb::MaskGrid>;
  const bool known = where.apply<Types>([&](const auto& grid) {
    tree = std::make_shared<openvdb::Vec3STree>(grid.tree(), openvdb::Vec3s(0.f), openvdb::TopologyCopy());
  });
  if (!known) throw InputError("no velocities are made where a grid of " + where.valueType() + " is active");
  tree->voxelizeActiveTiles();
  return tree;
}

double fastest(const openvdb::Vec3SGrid& grid) {
  double most = 0;
  for (auto v = grid.cbeginValueOn(); v; ++v) most = std::max(most, double(v->lengthSqr()));
  return std::sqrt(most);
}

}  // namespace

Carrier::Carrier(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Carrier::~Carrier() = default;
Carrier::Carrier(Carrier&&) noexcept = default;
Carrier& Carrier::operator=(Carrier&&) noexcept = default;

GridBase::ConstPtr Carrier::carry(const std::vector<GridBase::ConstPtr>& grids, const CarryOptions& options) {
  Impl& p = *impl_;
  if (grids.size() != p.weights.size())
    throw InputError(std::to_string(grids.size()) + " grids were given for " + std::to_string(p.weights.size()) + " objects");
  const auto first = std::find_if(grids.begin(), grids.end(), [](const auto& grid) { return bool(grid); });
  if (first == grids.end()) throw InputError("none of the objects has a grid to carry");
  const GridBase& like = **first;
  if (!canCarry(like)) throw InputError("values of the type " + like.valueType() + " cannot be carried");
  std::vector<CarriedGrid> carried;
  const size_t heaviest = size_t(std::max_element(p.weights.begin(), p.weights.end()) - p.weights.begin());
  bool half = true;
  for (size_t k = 0; k < grids.size(); ++k) {
    if (!grids[k]) continue;
    half = half && grids[k]->saveFloatAsHalf();
    if (p.weights[k] > 1 - kWhole && options.voxelSize == 0) return grids[k];
    if (p.weights[k] == 0 || !(isBlended(like) || k == heaviest)) continue;
    const size_t shape = p.shapeOf[k];
    carried.push_back({grids[k], shape, p.anchors[shape], p.weights[k]});
  }
  const GridBase::Ptr result = warped(carried, like, options);
  for (auto meta = like.beginMeta(); meta != like.endMeta(); ++meta)
    if (meta->first.compare(0, 5, "file_") != 0) result->insertMeta(meta->first, *meta->second);
  result->setSaveFloatAsHalf(half);
  return result;
}

GridBase::Ptr Carrier::warped(const std::vector<CarriedGrid>& carried, const GridBase& like,
                              const CarryOptions& options) {
  if (!carried.empty()) {
    const Transform::Ptr transform = options.voxelSize > 0 ? Transform::createLinearTransform(options.voxelSize)
                                                           : commonTransform(carried);
    const openvdb::CoordBBox box = boxOf(carried, impl_->carrying, *transform);
    if (!box.empty()) return warpGrids(carried, impl_->nodesFor(box, *transform), *transform, options.conserve);
  }
  GridBase::Ptr empty = like.copyGridWithNewTree();
  empty->setTransform(like.transform().copy());
  return empty;
}

Image Carrier::carry(const std::vector<const Image*>& images, const ImageLattice& on, const std::vector<double>& isos) const {
  const Impl& p = *impl_;
  if (images.size() != p.weights.size())
    throw InputError(std::to_string(images.size()) + " images were given for " + std::to_string(p.weights.size()) + " objects");
  std::vector<CarriedImage> carried;
  for (size_t k = 0; k < images.size(); ++k) {
    if (p.weights[k] > 1 - kWhole) return resampledTo(*images[k], on);
    const size_t shape = p.shapeOf[k];
    if (p.weights[k] > 0)
      carried.push_back({images[k], shape, p.anchors[shape], p.weights[k], p.fields.empty() ? nullptr : p.fields[shape].get(),
                         p.sizes[shape], isos.empty() ? std::nullopt : std::optional<double>(isos[k])});
  }
  return warpImages(carried, imageNodes(on, p.carrying, p.imageSpacing), on);
}

Image Carrier::carryLabels(const std::vector<const LabelField*>& labels, const ImageLattice& on) const {
  const Impl& p = *impl_;
  if (labels.size() != p.weights.size())
    throw InputError(std::to_string(labels.size()) + " label maps were given for " + std::to_string(p.weights.size()) + " objects");
  std::vector<CarriedLabels> carried;
  for (size_t k = 0; k < labels.size(); ++k)
    if (p.weights[k] > 0) carried.push_back({labels[k], p.shapeOf[k], p.anchors[p.shapeOf[k]], p.weights[k] * p.sizes[p.shapeOf[k]]});
  return warpLabels(carried, imageNodes(on, p.carrying, p.imageSpacing), on);
}

openvdb::Vec3SGrid::Ptr Carrier::velocity(const GridBase& where, const Weights& rate, double reach) const {
  auto result = openvdb::Vec3SGrid::create(topologyOf(where));
  result->setTransform(where.transform().copy());
  result->setName("vel");
  result->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  if (!impl_->carrying.lattice || result->empty()) return result;
  fillVelocities(*result, rate);
  const Vec3d size = result->voxelSize();
  const double far = reach * fastest(*result) / std::min({size[0], size[1], size[2]});
  if (far == 0) return result;
  openvdb::tools::dilateActiveValues(result->tree(), std::min(int(std::ceil(far)), kMostReach));
  fillVelocities(*result, rate);
  return result;
}

/// At the grid's active voxels, which are no tiles.
void Carrier::fillVelocities(openvdb::Vec3SGrid& grid, const Weights& rate) const {
  const Impl& p = *impl_;
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  Weights shapeRate(p.shapeWeights.size(), 0);
  for (size_t k = 0; k < rate.size(); ++k) shapeRate[p.shapeOf[k]] += rate[k];
  const NodeMap nodes = p.carrying.lattice->velocitiesWithin(box, p.shapeWeights, shapeRate, p.carrying.pose,
                                                             grid.transform(), carryingStep(box));
  const NodePlaces velocities(nodes);
  const int step = nodes.step;
  openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(grid.tree());
  leaves.foreach([&](openvdb::Vec3STree::LeafNodeType& leaf, size_t) {
    std::vector<openvdb::Vec3s> cell(size_t(step) * step * step);
    const openvdb::Coord o = leaf.origin();
    for (int x = 0; x < kLeaf; x += step)
      for (int y = 0; y < kLeaf; y += step)
        for (int z = 0; z < kLeaf; z += step) {
          const int i = (o[0] + x) / step, j = (o[1] + y) / step, k = (o[2] + z) / step;
          if (!nodes.inside(i, j, k) || !nodes.inside(i + 1, j + 1, k + 1)) continue;  // nothing is active there
          velocities.find(i, j, k, 0, cell);
          for (size_t v = 0; v < cell.size(); ++v) {
            const int a = int(v) / (step * step), b = int(v) / step % step, d = int(v) % step;
            const auto offset = leaf.coordToOffset({x + a, y + b, z + d});
            if (leaf.isValueOn(offset)) leaf.setValueOnly(offset, cell[v]);
          }
        }
  });
}

const NodeMap& Carrier::Impl::nodesFor(const openvdb::CoordBBox& box, const Transform& transform) {
  const auto same = std::find_if(nodes.begin(), nodes.end(), [&](const Nodes& n) { return *n.transform == transform; });
  openvdb::CoordBBox all = box;
  if (same != nodes.end()) {
    if (same->box.isInside(box)) return same->map;
    all.expand(same->box);
    nodes.erase(same);
  }
  if (nodes.size() == kKeptMaps) nodes.erase(nodes.begin());
  nodes.push_back({transform.copy(), all, carryingNodes(all, carrying, transform, carryingStep(all))});
  return nodes.back().map;
}

}  // namespace slicemorph
